"""Coefficients of the Radau IIA method of order 5.

From E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8,
and, for the transformation, from Hairer's program RADAU5.
"""

import numpy as np

_S = 6.0**0.5
C = np.array([(4.0 - _S) / 10.0, (4.0 + _S) / 10.0, 1.0])
A = np.array([
    [(88 - 7 * _S) / 360, (296 - 169 * _S) / 1800, (-2 + 3 * _S) / 225],
    [(296 + 169 * _S) / 1800, (88 + 7 * _S) / 360, (-2 - 3 * _S) / 225],
    [(16 - _S) / 36, (16 + _S) / 36, 1 / 9],
])  # fmt: skip
# Weights of the error estimate, of changes of velocities; those of positions go with E A.
E = np.array([(-13 - 7 * _S) / 3, (-13 + 7 * _S) / 3, -1 / 3])
E_A = E @ A
# Eigenvalues of the inverse of A, and what makes it block diagonal: T⁻¹ A⁻¹ T.
REAL = 3.0 + 3.0 ** (2 / 3) - 3.0 ** (1 / 3)
COMPLEX = 3.0 + 0.5 * (3.0 ** (1 / 3) - 3.0 ** (2 / 3))
IMAGINARY = 0.5 * (3.0 ** (5 / 6) + 3.0 ** (7 / 6))
T = np.array([
    [9.1232394870892942792e-2, -0.14125529502095420843, -3.0029194105147424492e-2],
    [0.24171793270710701896, 0.20412935229379993199, 0.38294211275726193779],
    [0.96604818261509293619, 1.0, 0.0],
])  # fmt: skip
T_INVERSE = np.array([
    [4.3255798900631553510, 0.33919925181580986954, 0.54177053993587487119],
    [-4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196],
    [-0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497],
])  # fmt: skip
# 1 / (COMPLEX ± i IMAGINARY): the matrices' c over h.
_NORM = COMPLEX**2 + IMAGINARY**2
C_REAL, C_COMPLEX, C_IMAGINARY = 1.0 / REAL, COMPLEX / _NORM, -IMAGINARY / _NORM
