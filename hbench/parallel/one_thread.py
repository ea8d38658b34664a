"""Environment of a process whose linear algebra has one thread.

The matrices are small: more threads would wait for each other most of the time. With two threads,
a search for hidden effects takes more than twice the CPU time and no less wall time.
"""

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_MAX_THREADS"), "1"
)
