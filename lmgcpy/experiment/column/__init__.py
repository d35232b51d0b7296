"""Columns of sand, without and with wire: sample, pour and release, study, report."""
