"""The engine of all studies: :mod:`lmgcpy.experiment.study.engine` says how a study is written."""
