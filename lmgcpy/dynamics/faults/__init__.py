"""What broke in a step that could not be made: numbers that are not finite, and the law or the body at fault."""
