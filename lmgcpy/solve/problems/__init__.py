"""Problems that stand alone, from the top down: ``problem``, its ``residual``, the ``report`` of a solve, ``locked``."""
