"""What is compiled for each group, from the top down: ``law_kernels`` fills the names that ``contact_block``,
``wire_block`` and ``stiffened_wire_block`` leave open, with a law and one of the ``forms``; all work on a ``system``."""
