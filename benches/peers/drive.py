"""What `sindy.py` starts from: recordings, machine file, and the base model, the tool's equations and conventions written anew."""
import tomllib

import numba
import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import lfilter, savgol_filter

TICK = 1e-3
KNOWN = {"time [s]": "t", "command [V]": "u", "spool [1]": "x", "position [m]": "y", "pressure_a [Pa]": "pa", "pressure_b [Pa]": "pb",
         "supply_pressure [Pa]": "ps", "oil_temperature [°C]": "T"}
CHANNELS = ("x", "pa", "pb", "ps", "y")


def noise_of(values):
    steps = np.abs(np.diff(values))
    quantum = steps[steps > 0].min() if steps.any() else 0.0
    return np.hypot(np.median(np.abs(np.diff(values, 3))) / 0.6745 / np.sqrt(20), quantum / np.sqrt(12))


def smoothed(values):
    return savgol_filter(values, 7, 2, axis=0)


def read(path):
    """A recording without its spikes, by row (`rec`) and by tick (`w`)."""
    with open(path, encoding="utf-8-sig") as file:
        names = [cell.strip() for cell in file.readline().split(",")]
    columns = np.loadtxt(path, delimiter=",", skiprows=1, encoding="utf-8").T
    rec = {KNOWN[name]: column for name, column in zip(names, columns) if name in KNOWN}
    if missing := {"t", "u", "y"} - set(rec):
        raise ValueError(f"{path}: no column {', '.join(k for k, v in KNOWN.items() if v in missing)}")
    rec["t"] = rows = rec["t"] - rec["t"][0]
    rec["noise"], t = {}, np.arange(0, rows[-1] + TICK / 2, TICK)
    rec["w"] = w = dict(t=t, u=rec["u"][np.searchsorted(rows, t + 1e-9, side="right") - 1])
    rec["channels"] = [c for c in CHANNELS if c in rec]
    for c in rec["channels"]:
        middle = median_filter(rec[c], 5)
        spike = np.abs(rec[c] - middle) > 8 * noise_of(rec[c]) + 3 * np.abs(np.gradient(middle))
        rec[c] = np.where(spike, middle, rec[c])
        rec["noise"][c] = noise_of(rec[c])
        w[c] = np.interp(t, rows, smoothed(rec[c]))
    if "T" in rec:
        w["T"] = np.interp(t, rows, rec["T"])
    row = rows[1]
    wide = max(5, int(0.03 / row) // 2 * 2 + 1)
    w["v"] = np.interp(t, rows, savgol_filter(rec["y"], wide, 2, deriv=1, delta=row))
    w["v_noise"] = rec["noise"]["y"] / row * np.sqrt(12 / wide**3)
    rec["tick"] = np.minimum(np.round(rows / TICK).astype(int), len(t) - 1)
    return rec


def machine_of(path):
    """Values and standard deviations by the names of [fit.sigma]; `level` is that of the pressures at rest, parts of the supply."""
    with open(path, "rb") as file:
        tables = tomllib.load(file)
    if "sigma" not in tables.get("fit", {}):
        raise ValueError(f"{path}: no [fit.sigma], which says how far a value may move")
    values = {"supply.tank_pressure_pa": 0.0, "load.force_n": 0.0, "level": 0.0}
    for table in ("supply", "valve", "cylinder", "load"):
        for key, value in tables.get(table, {}).items():
            each = enumerate(value) if isinstance(value, list) else [(None, value)]
            values.update({f"{table}.{key}" + ("" if k is None else f"[{k}]"): v for k, v in each})
    return values, {**{k: s for k, s in tables["fit"]["sigma"].items() if k in values}, "level": 0.1}


@numba.njit(cache=True)
def limited(target, most):
    """Mean over each tick behind the rate limit."""
    out, now = np.empty_like(target), target[0]
    for k in range(len(target)):
        step = min(max(target[k] - now, -most), most)
        now += step
        out[k] = now - step * abs(step) / most / 2
    return out


@numba.njit(cache=True)
def root(dp):
    return dp / (dp * dp + 4e6) ** 0.25


@numba.njit(cache=True)
def edges(x, pa, pb, ps, c):
    """Flow into A and out of B."""
    pt, kq, dz, most = c[0], c[1], c[2], c[3]
    o = kq * (x - dz) if x > dz else (kq * (x + dz) if x < -dz else 0.0)
    qa, qb = (o * root(ps - pa), o * root(pb - pt)) if o > 0 else (o * root(pa - pt), o * root(ps - pb))
    return min(max(qa, -most), most), min(max(qb, -most), most)


@numba.njit(cache=True)
def flows(x, pa, pb, ps, c):
    qa, qb = np.empty_like(x), np.empty_like(x)
    for k in range(len(x)):
        qa[k], qb[k] = edges(x[k], pa[k], pb[k], ps[k], c)
    return qa, qb


@numba.njit(cache=True)
def rates(x, ps, ia, ib, f, z, c):
    A, B, ea, eb, m, D = c[4], c[5], c[6], c[7], c[8], c[9]
    pa, pb, v, _ = z
    qa, qb = edges(x, pa, pb, ps, c)
    return ea * (qa + ia - A * v), eb * (B * v - qb - ib), (f + A * pa - B * pb - D * v) / m, v


@numba.njit(cache=True)
def moved(z, h, k):
    return z[0] + h * k[0], z[1] + h * k[1], z[2] + h * k[2], z[3] + h * k[3]


@numba.njit(cache=True)
def hydraulics(x, ps, ia, ib, f, z, c, n):
    """RK4 with n substeps; both pressures, velocity, position."""
    out, h = np.empty((len(x), 4)), TICK / n
    for k in range(len(x)):
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = z
        step = (x[min(k + 1, len(x) - 1)] - x[k]) / n
        for i in range(n):
            start, middle, end = x[k] + step * i, x[k] + step * (i + 0.5), x[k] + step * (i + 1)
            k1 = rates(start, ps[k], ia[k], ib[k], f[k], z, c)
            k2 = rates(middle, ps[k], ia[k], ib[k], f[k], moved(z, h / 2, k1), c)
            k3 = rates(middle, ps[k], ia[k], ib[k], f[k], moved(z, h / 2, k2), c)
            k4 = rates(end, ps[k], ia[k], ib[k], f[k], moved(z, h, k3), c)
            z = moved(moved(moved(moved(z, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4)
    return out


def lag(signal, constant, held=False):
    a = np.exp(-TICK / max(constant, 1e-4))
    b = [0, 1 - a] if held else [(1 - a) / 2, (1 - a) / 2]
    return lfilter(b, [1, -a], signal, zi=[(1 - b[0]) * signal[0]])[0]


def integral(q):
    return TICK * lfilter([0.5, 0.5], [1, -1], q, zi=[-0.5 * q[0]])[0]


def simulate(p, w, put={}, noise={}):
    """By tick, what the channels should read (x y pa pb ps) and what the links saw (`at`).  What is put in: command and spool (`valve`, `spool`),
    flows (`qa` into A, `qb` out of B), force (`f`), and by a channel's name what its sensor adds."""
    zero = np.zeros(len(w["t"]))
    more = lambda key: put.get(key, zero)
    entered = lambda c, own: w[c] + noise.get(c, 0.0) - more(c) if c in w else own
    aim = limited(p["valve.gain_per_v"] * w["u"] + p["valve.offset"], max(p["valve.rate_limit_per_s"], 0.1) * TICK)
    aim = np.interp(w["t"] - p["valve.transport_delay_s"], w["t"], aim) + more("valve")
    spool = lag(lag(aim, p["valve.time_constants_s[0]"], True), p["valve.time_constants_s[1]"]) + more("spool")
    A, B, E, m, D, p0, f0 = (p[k] for k in ("cylinder.area_a_m2", "cylinder.area_b_m2", "cylinder.bulk_modulus_pa", "cylinder.moving_mass_kg",
                                            "cylinder.viscous_friction_n_s_per_m", "supply.pressure_pa", "load.force_n"))
    ea, eb, force = E / p["cylinder.volume_a_m3"], E / p["cylinder.volume_b_m3"], f0 + more("f")
    c = (p["supply.tank_pressure_pa"], p["valve.flow_coefficient"], p["valve.dead_zone"], p["supply.flow_limit_m3_per_s"], A, B, ea, eb, m, D)
    x, ps = entered("x", spool), entered("ps", zero + p0)
    if "pa" in w and "pb" in w:
        pa, pb, way = entered("pa", zero), entered("pb", zero), entered("y", zero)
        way = way - way[0]
        qa, qb = flows(x, pa, pb, ps, c)
        own_a, own_b = pa[0] + ea * (integral(qa + more("qa")) - A * way), pb[0] + eb * (B * way - integral(qb + more("qb")))
        y = w["y"][0] + integral(lag(force + A * pa - B * pb, m / D) / D)
    else:
        level = (0.5 + p["level"]) * p0
        n = max(2, int(np.ceil(TICK * (D / m + np.sqrt((A * A * ea + B * B * eb) / m)) / 1.8)))
        rest = (level, (A * level + f0) / B, 0.0, w["y"][0])
        pa, pb, _, y = (own_a, own_b, _, y) = hydraulics(x, ps, more("qa"), more("qb"), force, rest, c, n).T
        qa, qb = flows(x, pa, pb, ps, c)
    return dict(x=spool + more("x"), pa=own_a + more("pa"), pb=own_b + more("pb"), ps=p0 + more("ps"), y=y + more("y"), at=(x, pa, pb, ps, qa, qb))


def warm():
    """Has the kernels compiled, so that no case pays for it."""
    z, c = np.zeros(3), (1.0,) * 10
    limited(z, 1.0), flows(z, z, z, z, c), hydraulics(z, z, z, z, z, (1.0,) * 4, c, 2)
