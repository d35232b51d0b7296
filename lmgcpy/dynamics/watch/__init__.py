"""What a run watches, and says to the user: each file finds one thing and has its sentence."""
