"""Solvers by sweeps, from the top down: ``solver``, the ``step`` that it gets, ``gauss_seidel`` and ``accelerated``,
the parts of a ``sweep``, and the ``team`` of threads that does them."""
