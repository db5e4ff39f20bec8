"""Dense linear algebra in compiled code: LU, full pivoting, rank-revealing solutions."""
