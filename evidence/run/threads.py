"""What keeps a process on one thread."""

#: Variables of the environment with the number of threads of a library.
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")
