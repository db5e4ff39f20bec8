"""Machines of one freedom by quadrature: the four-bar of any mass, the stalling compressor."""

from functools import cache

import mpmath as mp

from models.hard.suite.closed import DIGITS, Number, OneFreedom

G = "9.81"


@cache
def four_bar(ratio: float, t: float, speed: float) -> float:
    """Crank angle at the time t of `mass_ratio`, rad: bars 1, 3, 3 and 3 m, open assembly."""
    with mp.workdps(DIGITS):
        a, b, c, d = map(mp.mpf, (1, 3, 3, 3))
        crank, coupler, rocker = mp.mpf(1), mp.mpf(ratio), mp.mpf(1)

        def felt(phi: Number) -> tuple[Number, Number]:
            bx, by = a * mp.cos(phi), a * mp.sin(phi)
            distance = mp.sqrt((d - bx) ** 2 + by**2)
            cosine = (distance**2 + b**2 - c**2) / (2 * b * distance)
            phi2 = mp.atan2(-by, d - bx) + mp.acos(cosine)
            cx, cy = bx + b * mp.cos(phi2), by + b * mp.sin(phi2)
            s2, c2, s3, c3 = (cy - by) / b, (cx - bx) / b, cy / c, (cx - d) / c
            s1, c1 = by / a, bx / a
            # Rates of coupler and rocker per rate of the crank: both give C the same velocity.
            across = s2 * c3 - c2 * s3
            rate2 = -a * (s1 * c3 - c1 * s3) / (b * across)
            rate3 = a * (c1 * s2 - s1 * c2) / (c * across)
            vx, vy = -a * s1 - b * rate2 * s2 / 2, a * c1 + b * rate2 * c2 / 2
            inertia = crank * a**2 / 3 + rocker * c**2 * rate3**2 / 3
            inertia += coupler * (vx**2 + vy**2 + b**2 * rate2**2 / 12)
            height = crank * by / 2 + coupler * (by + cy) / 2 + rocker * cy / 2
            return inertia, -mp.mpf(G) * height

        _, lift = felt(mp.mpf(0))
        return float(
            OneFreedom(
                lambda phi: (felt(phi)[0], felt(phi)[1] - lift), mp.mpf(0), mp.mpf(speed)
            ).periodic(t)
        )


@cache
def stall(inertia: float) -> tuple[float, float]:
    """When and where the compressor of section 8.2.4 stalls: s, rad.

    From φ1 = π on the slider moves right until the crank has done all its work; the speed vanishes
    there as the root of the way left, which the substitution φ = φ_s - u² takes out of the time.
    """
    with mp.workdps(DIGITS):
        r, rod, begin, speed = mp.mpf(2), mp.mpf("3.5"), mp.pi, mp.mpf(30)
        rod_mass, slider_mass = mp.mpf(35), mp.mpf(25)

        def place(phi: Number) -> tuple[Number, Number]:
            return r * mp.cos(phi) + mp.sqrt(rod**2 - (r * mp.sin(phi)) ** 2), phi

        def gas(x: Number) -> Number:
            """Work of the gas from x = 1.5 m on, J."""
            x = min(max(x, mp.mpf("1.5")), mp.mpf("5.5"))
            full = min(x, mp.mpf(5))
            work = 282857 * mp.log((6 - full) / mp.mpf("4.5")) + 62857 * (full - mp.mpf("1.5"))
            if x > 5:
                turn = 2 * mp.pi
                work -= 110000 * (x - 5 + mp.cos(turn * (x - mp.mpf("5.25"))) / turn)
            return work

        def moment(phi: Number) -> Number:
            """Σ m x, kg m: what gravity along +x pulls at."""
            x, _ = place(phi)
            return rod_mass * (r * mp.cos(phi) + x) / 2 + slider_mass * x

        def felt(phi: Number) -> tuple[Number, Number]:
            s, c = mp.sin(phi), mp.cos(phi)
            across = mp.sqrt(rod**2 - (r * s) ** 2)
            turn = -r * c / across  # of the rod, per rate of the crank
            slide = -r * s - r**2 * s * c / across
            vx, vy = (slide - r * s) / 2, r * c / 2
            felt_inertia = inertia + rod_mass * (vx**2 + vy**2) + 35 * turn**2
            felt_inertia += slider_mass * slide**2
            work = 41450 * (phi - begin) + mp.mpf(G) * (moment(phi) - moment(begin))
            return felt_inertia, work + gas(place(phi)[0])

        machine = OneFreedom(felt, begin, speed)
        start = felt(begin)[0] * speed**2 / 2

        def left(phi: Number) -> Number:
            return start + felt(phi)[1]

        end = mp.findroot(left, (mp.mpf("5.79"), mp.mpf("5.80")), solver="anderson")
        edge = mp.findroot(lambda phi: place(phi)[0] - 5, mp.mpf("5.6"))
        whole = machine.time(begin, edge, 16)
        reach = mp.sqrt(end - edge)
        whole += mp.quad(
            lambda u: 2 * u / machine.rate(end - u**2),
            [0, reach / 2, reach],
            method="gauss-legendre",
        )
        return float(whole), float(end)
