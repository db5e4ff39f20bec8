"""Explicit Runge-Kutta method of order 5(4) with dense output of order 4.

The pair is J. R. Dormand and P. J. Prince's (A family of embedded Runge-Kutta formulae, Journal of
Computational and Applied Mathematics 6, 1980); the dense output, L. F. Shampine's (Some practical
Runge-Kutta formulas, Mathematics of Computation 46, 1986), and its constants are those of
E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I, section II.6.
k_7, the derivative at the end, is the first stage of the next step.

On the imaginary axis it is stable up to one radian a step, where its estimate of the error is less
than a thousandth: at looser tolerances accuracy alone does not keep a vibration from growing, and
`stability_limit` does.
"""

from codegen.tableaus.tableau import Tableau, difference, stages, weights

B = weights("35/384 0 500/1113 125/192 -2187/6784 11/84")
EMBEDDED = weights("5179/57600 0 7571/16695 393/640 -92097/339200 187/2100 1/40")

TABLEAU = Tableau(
    about=__doc__,
    order=5,
    error_order=4,
    stages=stages("""
        1/5  | 1/5
        3/10 | 3/40        9/40
        4/5  | 44/45      -56/15       32/9
        8/9  | 19372/6561 -25360/2187  64448/6561  -212/729
        1    | 9017/3168  -355/33      46732/5247   49/176  -5103/18656
    """),
    b=B,
    error=difference(B, EMBEDDED),
    dense_order=4,
    dense=(
        weights("""
            -12715105075/11282082432    0  87487479700/32700410799  -10690763975/1880347072
            701980252875/199316789632  -1453857185/822651844         69997945/29380423
        """),
    ),
    # Half the estimate of the error of a vibration at the edge of stability, over its amplitude.
    # Where a tolerance is less than that, with its absolute part as much again, no vibration grows.
    stability_edge=4e-4,
)
