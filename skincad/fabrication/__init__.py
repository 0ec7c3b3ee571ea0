"""From plans to what a workshop needs: print meshes, findings, the casting sheet."""
