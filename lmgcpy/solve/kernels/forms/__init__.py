"""Forms of the rows of ``H^T``: how an interaction meets the velocities of its bodies."""
