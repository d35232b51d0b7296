"""Speed against error: problems, references, work-precision and performance profiles (``lmgcpy bench``)."""
