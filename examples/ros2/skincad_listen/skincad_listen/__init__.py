"""What `skincad listen` hears, as ROS 2 topics."""
