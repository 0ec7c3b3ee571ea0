"""The page with sliders: what is edited, what answers it, and the browser's side of both."""
