"""Speed against error: problems, references, work-precision diagrams and performance profiles (``lmgcpy bench``)."""
