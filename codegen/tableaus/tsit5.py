"""Explicit Runge-Kutta method of order 5(4) with dense output of order 4.

The pair and its dense output are Ch. Tsitouras's (Runge-Kutta pairs of order 5(4) satisfying only
the first column simplifying assumption, Computers & Mathematics with Applications 62, 2011). k_7,
the derivative at the end, is the first stage of the next step. At equal cost its errors are as
large as those of dopri5, or smaller by up to a factor of seven at tight tolerances.

On the imaginary axis it is stable up to half a radian a step only, and hardly unstable up to one:
at loose tolerances `stability_limit` keeps vibrations within that half, and the steps of dopri5,
stable up to one radian, are longer.
"""

from codegen.tableaus.tableau import Tableau, difference, stages, weights

B = weights("""
    0.09646076681806522951816731316512876333712  1/100
    0.4798896504144995747752495322905965199130   1.379008574103741893192274821856872770756
   -3.290069515436080679901047585711363850116    2.324710524099773982415355918398765796109
""")
EMBEDDED = weights("""
    0.09468075576583945807478876255758922856118  0.009183565540343253096776363936645313759814
    0.4877705284247615707855642599631228241517   1.234297566930478985655109673884237654036
   -2.707712349983525454881109975059321670690    1.866628418170587035753719399566211498666
    1/66
""")

TABLEAU = Tableau(
    about=__doc__,
    order=5,
    error_order=4,
    stages=stages("""
        0.161 | 0.161
        0.327 | -0.008480655492356988544426874250230774675121
                 0.3354806554923569885444268742502307746751
        0.9   |  2.897153057105493432130432594192938764925
                -6.359448489975074843148159912383825625953
                 4.362295432869581411017727318190886861028
        0.9800255409045096857298102862870245954942 |
                 5.325864828439256604428877920840511317836
               -11.74888356406282787774717033978577296189
                 7.495539342889836208304604784564358155659
                -0.09249506636175524925650207933207191611350
        1     |  5.861455442946420028659251486982647890394
               -12.92096931784710929170611868178335939542
                 8.159367898576158643180400794539253485182
                -0.07158497328140099722453054252582973869127
                -0.02826905039406838290900305721271224146718
    """),
    b=B,
    error=difference(B, EMBEDDED),
    dense_order=4,
    dense=(
        weights("""
            -1.0530884977290216    0.1017                 2.490627285651252793
            -16.54810288924490272  47.37952196281928122  -34.87065786149660974  2.5
        """),
    ),
    stability_edge=5e-6,  # as that of dopri5
)
