"""PySINDy in an expert's hands: names missing physics from the residuals of the refitted base model, in weak form.  Says in a line of JSON what
it is, then answers each line `CASE<tab>OUT.json` with the seconds it took and the most memory so far; OUT.json is a diagnosis in the tool's format.  Of a case it reads the
machine file and the training recordings (evenly sampled), and all cases are judged by the same rules:

1. The base model (the tool's equations and conventions, written anew) is entered at every signal that is recorded, and simulates the others.
   What it misses in a channel is the balance of a link, integrated: the spool behind its lags, the oil of A and of B, the supply, the position.
2. `WeakPDELibrary` takes two widths of window a channel; each row counts in units of the noise that the sensors predict there (drawn, and sent
   through the same model and windows).  The parameters of [fit.sigma] are refitted on these rows, robustly; then their directions are projected out.
   A case that is within the noise is left alone.
3. The library: each effect in a few shapes, as terms of the recorded and simulated signals that are put into their link.
4. `STLSQ` regresses on each shape; coefficients without a physical sign are refused, and the likeliest five effects are simulated once more with
   the effect in its place.  The best must take away half of what is above the noise, a richer law of friction must leave a good deal less than plain
   friction does.  Then `STLSQ` again, on that shape and each other one: a second effect must stand out of what a wrong shape of the first may
   leave, and take away three quarters of what its link still misses.
"""
import json
import sys
import time
import warnings
from glob import glob

import numba
import numpy as np
import pysindy
from scipy.integrate import cumulative_trapezoid
from scipy.signal import lfilter, savgol_filter
from scipy.sparse import csr_array

from drive import TICK, machine_of, read, root, simulate, smoothed, warm

LINKS = dict(x="valve", pa="oil", pb="oil", ps="supply", y="mechanics")  # by channel
WIDTHS = (0.025, 0.15)  # half a window, s
FAR = 2.5  # standard deviations that a refitted value may be from its nominal one
GATE = 2.0  # mean square of one kind of rows, noise being 1: below, nothing is looked for
STRANGE = 4.0  # the same: above, a mismatch that no effect explains is owned up to
FAINT = 5.0  # STLSQ's threshold: coefficients by their standard deviation
SHOWN = 0.1  # what an effect must take away from the mean square of all rows
HALF = 0.5  # share of a link's excess over the noise that an effect must take away
MORE = 0.75  # the same for a second effect
RICHER = 0.5  # share of plain friction's remaining excess that a richer law may leave
ROUGH = 0.3  # how wrong the shape of a first effect may be

warnings.filterwarnings("ignore", message="Sparsity parameter is too big")


@numba.njit(cache=True)
def play(u, half):
    out, now = np.empty_like(u), u[0]
    for k in range(len(u)):
        now = min(max(now, u[k] - half), u[k] + half)
        out[k] = now
    return out


@numba.njit(cache=True)
def stick(u, width):
    """Holds until it is left by a width, then jumps."""
    out, now = np.empty_like(u), u[0]
    for k in range(len(u)):
        if abs(u[k] - now) > width:
            now = u[k]
        out[k] = now
    return out


@numba.njit(cache=True)
def bristle(v, length):
    """Direction of dry friction, which it keeps at rest."""
    out, z = np.empty_like(v), 0.0
    for k in range(len(v)):
        z = (z + v[k] * TICK) / (1 + abs(v[k]) / length * TICK)
        out[k] = z / length
    return out


def library(p, w, sim):
    """Effect: its shapes; a shape is a list of terms, a term what is put in where."""
    (x, pa, pb, ps, qa, qb), t, y = sim["at"], w["t"], w["y"]
    pt, p0, kq, dz, most, A, B, E = (p[k] for k in (
        "supply.tank_pressure_pa", "supply.pressure_pa", "valve.flow_coefficient", "valve.dead_zone", "supply.flow_limit_m3_per_s",
        "cylinder.area_a_m2", "cylinder.area_b_m2", "cylinder.bulk_modulus_pa"))
    v = np.where(np.abs(w["v"]) > 3 * w["v_noise"], w["v"], 0.0)
    o, one = np.sign(x) * np.maximum(np.abs(x) - dz, 0), np.ones_like(t)
    up, down, span = (o > 0) * one, (o < 0) * one, w["top"] * p["valve.gain_per_v"]
    aim = p["valve.gain_per_v"] * w["u"] + p["valve.offset"]
    slope = lambda dp: 0.5 / np.sqrt(np.abs(dp) + 1e5)
    supplied, returned = up * qa - down * qb, up * qb - down * qa
    behind = lambda q, tau: lfilter([1 - np.exp(-TICK / tau)], [1, -np.exp(-TICK / tau)], q) if tau else q
    dpa, dpb = (savgol_filter(q, 21, 2, deriv=1, delta=TICK) for q in (pa, pb))
    oil = lambda a, b: {"qa": a, "qb": b}
    push = lambda f: {"f": 0.01 * p0 * A * f}
    rub = lambda f: push(-f)
    (first, last), mid = w["range"], 0.5 * p["cylinder.stroke_m"]
    at, along = (y - mid) / mid, (2 * y - first - last) / (last - first)
    dry = [bristle(v, length) for length in (2e-5, 8e-5, 2e-4)]
    warm = (w["T"] - 30) / 10 if "T" in w else t / w["longest"]
    leak = lambda s: oil(0.02 * kq * s * (root(ps - pa) - root(pa - pt)), -0.02 * kq * s * (root(ps - pb) - root(pb - pt)))
    soft = lambda q, p1: (p1 / (np.maximum(q, 0) + p1)) ** 2 * 10 / E
    air = lambda p1: oil(-dpa * p["cylinder.volume_a_m3"] * soft(pa, p1), dpb * p["cylinder.volume_b_m3"] * soft(pb, p1))
    jet = up * (np.abs(ps - pa) + np.abs(pb - pt)) + down * (np.abs(ps - pb) + np.abs(pa - pt))

    def droop(tau):
        drop = behind(supplied, tau) / most * 1e5
        return {"ps": -drop} if "ps" in w else oil(-up * kq * o * slope(ps - pa) * drop, -down * kq * o * slope(ps - pb) * drop)

    rise = np.abs(returned) * returned / most**2 * 1e5
    found = {
        "valve-hysteresis": [[{"valve": play(aim, h * span) - aim}] for h in np.geomspace(0.002, 0.04, 10)],
        "spool-stiction": [[{"spool": stick(sim["x"], h) - sim["x"]}] for h in np.geomspace(0.003, 0.03, 16)],
        "null-drift": [[{"valve": 0.01 * warm}], [{"valve": 0.01 * np.sin(2 * np.pi * t / w["longest"])}]],
        "solenoid-saturation": [[{"valve": -0.1 * np.sign(aim) * np.maximum(np.abs(aim) - h * span, 0)}] for h in (0.3, 0.5, 0.7, 0.85)],
        "flow-force": [[{"valve": -0.1 * o * jet / p0}]],
        "dead-zone-asymmetry": [[oil(-0.01 * kq * (up * root(ps - pa) + down * root(pa - pt)),
                                     -0.01 * kq * (up * root(pb - pt) + down * root(ps - pb)))]],
        "flow-gain-nonlinearity": [[oil(0.3 * qa * k, 0.3 * qb * k)] for k in (
            *((np.abs(o) / span) ** n for n in (0.5, 1, 2)), *(np.exp(-np.abs(o) / (h * span)) for h in (0.05, 0.15)))],
        "metering-asymmetry": [[oil(0.05 * qa * (up - down), 0.05 * qb * (down - up))]],
        "supply-droop": [[droop(tau)] for tau in (0, 0.05, 0.15, 0.4)],
        "tank-back-pressure": [[oil(-down * kq * o * slope(pa - pt) * rise, -up * kq * o * slope(pb - pt) * rise)]],
        "valve-leakage": [[leak(np.exp(-((x / (h * max(dz, 0.01))) ** 2)))] for h in (0.3, 0.6, 1.0)],
        "internal-leakage": [[oil(-1e-13 * (pa - pb), -1e-13 * (pa - pb))]],
        "external-leakage": [[oil(-1e-13 * pa, 0 * pa)], [oil(0 * pb, 1e-13 * pb)]],
        "entrained-air": [[air(p1)] for p1 in (2e5, 6e5)],
        "position-dependent-volume": [[oil(-A * (y - mid) / E * dpa, -B * (y - mid) / E * dpb)]],
        "coulomb-friction": [[rub(d)] for d in dry],
        "stribeck-friction": [[rub(d), rub(d * np.exp(-((v / vs) ** 2)))] for d in dry for vs in (0.003, 0.01, 0.03)],
        "friction-asymmetry": [[rub(d), rub(np.abs(d))] for d in dry],
        "position-dependent-friction": [[rub(d), rub(d * along**k)] for d in dry for k in (1, 2)],
        "pressure-dependent-friction": [[rub(d * (pa + pb) / p0)] for d in dry],
        "presliding": [[rub(bristle(v, length))] for length in (4e-4, 8e-4)],
        "position-dependent-load": [[push(one), push(at)]],
        "end-stop": [[rub(s)] for d in (5e-4, 2e-3, 5e-3) for s in (np.maximum(y - last + d, 0) / d, np.minimum(y - first - d, 0) / d)],
        "oil-temperature": [[rub(-10 * v * warm)]],
        "linkage-backlash": [[{"y": play(sim["y"], h) - sim["y"]}] for h in (4e-5, 7e-5, 1.2e-4, 2e-4, 3e-4, 4.5e-4, 7e-4, 1e-3)],
        "position-sensor-lag": [[{"y": -0.005 * w["v"]}]],
        "sensor-offset": [[{c: 1e5 * one}] for c in ("pa", "pb", "ps") if c in w],
    }
    return {effect: shapes for effect, shapes in found.items() if shapes}


SIGNED = ("valve.offset", "load.force_n", "level")
EITHER = ("null-drift", "dead-zone-asymmetry", "flow-gain-nonlinearity", "metering-asymmetry", "oil-temperature", "sensor-offset")
RICH = ("stribeck-friction", "friction-asymmetry", "position-dependent-friction", "pressure-dependent-friction", "presliding")
PLAIN = "coulomb-friction"


def physical(effect, c):
    """Whether coefficients are an effect's: friction brakes, leakage flows to the lower pressure, a spring is at rest within the stroke."""
    if effect == "friction-asymmetry":
        return c[0] > abs(c[1])
    if effect == "position-dependent-friction":
        return c[0] + 0.3 * abs(c[1]) > 0
    if effect == "position-dependent-load":
        return abs(c[0]) <= abs(c[1])
    return bool(np.any(c) if effect in EITHER else np.all(c > 0))


def stlsq(columns, rows, threshold=FAINT):
    size = np.linalg.norm(columns, axis=0)
    size[size < 1e-9] = 1.0
    return pysindy.STLSQ(threshold=threshold, alpha=0.0).fit(columns / size, rows[:, None]).coef_[0] / size


class Case:
    """Weak rows of a case: `z` what the refitted model misses, `G` what each term of the library would add, both without the uncertain parameters."""

    def __init__(self, folder):
        np.random.seed(0)  # WeakPDELibrary draws where its windows are
        self.nominal, self.sigma = machine_of(f"{folder}/machine.toml")
        self.recs = [read(path) for path in sorted(glob(f"{folder}/train-*.csv"))]
        if not self.recs:
            raise ValueError(f"{folder}: no recording train-*.csv")
        bounds = [(r["y"].min(), r["y"].max()) for r in self.recs]
        top, longest = max(np.abs(r["u"]).max() for r in self.recs), max(r["t"][-1] for r in self.recs)
        for r in self.recs:
            r["w"].update(range=(min(b[0] for b in bounds), max(b[1] for b in bounds)), top=top, longest=longest)
            r["weak"] = {h: windows(r["t"], h) for h in WIDTHS}
        self.names = [k for k in self.sigma if k != "level" or "pa" not in self.recs[0]]
        self.unit = [1.0] * len(self.recs)
        self.kind = np.concatenate([[f"{c} {h}" for c in r["channels"] for h in WIDTHS for _ in range(r["weak"][h].shape[0])] for r in self.recs])
        self.kinds = {k: self.kind == k for k in dict.fromkeys(self.kind)}
        self.predict_noise()
        self.refit()

    def values(self, theta):
        moved = {k: self.nominal[k] + s * self.sigma[k] for k, s in zip(self.names, theta)}
        return {**self.nominal, **{k: v if k in SIGNED else max(v, 0.3 * self.nominal[k]) for k, v in moved.items()}}

    def weak(self, r, signals):
        """Weak derivative of each channel's balance; what does not integrate (spool, supply) is integrated first."""
        rows = []
        for c in r["channels"]:
            s = cumulative_trapezoid(signals[c], r["t"], axis=0, initial=0.0) if c in ("x", "ps") else signals[c]
            rows += [r["weak"][h] @ s for h in WIDTHS]
        return np.concatenate(rows)

    def rows(self, of_recording):
        return np.concatenate([self.weak(r, s) / u for r, s, u in zip(self.recs, of_recording, self.unit)])

    def predict_noise(self):
        rng, p, draws = np.random.default_rng(0), self.values(np.zeros(len(self.names))), 3
        for i, r in enumerate(self.recs):
            w, base = r["w"], simulate(p, r["w"])
            drawn = {c: rng.normal(size=(len(r["t"]), draws)) * r["noise"][c] for c in r["channels"]}
            at_ticks = [{c: np.interp(w["t"], r["t"], smoothed(d[:, k])) for c, d in drawn.items()} for k in range(draws)]
            for k, noise in enumerate(at_ticks):
                noisy = simulate(p, w, noise=noise)
                for c in r["channels"]:
                    drawn[c][:, k] -= (noisy[c] - base[c])[r["tick"]]
            z, start, unit = self.weak(r, drawn), 0, []
            for k in [r["weak"][h].shape[0] for c in r["channels"] for h in WIDTHS]:
                unit += [np.sqrt(np.mean(z[start : start + k] ** 2))] * k
                start += k
            self.unit[i] = np.array(unit)[:, None]

    def run(self, theta, put=None):
        p = self.values(theta)
        return [simulate(p, r["w"], put[i] if put else {}) for i, r in enumerate(self.recs)]

    def missing(self, sims):
        return self.rows([{c: (r[c] - s[c][r["tick"]])[:, None] for c in r["channels"]} for r, s in zip(self.recs, sims)])[:, 0]

    def change(self, sims, others, step):
        """Columns: what the rows change by in each other run, for a unit of what was changed by a step."""
        return self.rows([{c: np.stack([(o[i][c] - s[c])[r["tick"]] / step for o in others], axis=1) for c in r["channels"]}
                          for i, (r, s) in enumerate(zip(self.recs, sims))])

    def along(self, theta, sims):
        return self.change(sims, [self.run(theta + 0.1 * e) for e in np.eye(len(theta))], 0.1)

    def refit(self):
        theta, eye = np.zeros(len(self.names)), np.eye(len(self.names))
        for _ in range(3):
            sims = self.run(theta)
            z, N = self.missing(sims), self.along(theta, sims)
            spread = max(1.0, np.median(np.abs(z)) / 0.6745)
            weight = 1 / np.maximum(np.abs(z) / (3 * spread), 1) / spread**2
            theta = np.clip(np.linalg.solve((N.T * weight) @ N + eye, (N.T * weight) @ (z + N @ theta)), -FAR, FAR)
        self.theta, self.sims = theta, self.run(theta)
        self.N = self.along(theta, self.sims)
        self.move = np.linalg.solve(self.N.T @ self.N + eye, self.N.T)  # rows to the likeliest parameters
        u, s, _ = np.linalg.svd(self.N, full_matrices=False)
        self.project = lambda m: m - u @ (((1 - 1 / np.sqrt(1 + s * s)) * (u.T @ m).T).T)
        self.given = self.missing(self.sims) + self.N @ theta
        self.z = self.project(self.given)

    def library(self, theta, sims):
        p = self.values(theta)
        return [library(p, r["w"], s) for r, s in zip(self.recs, sims)]

    def columns(self, theta, sims, terms, put=None, little=0.02):
        """Response to each term; `terms` holds, of each, what it puts in by recording."""
        add = lambda term, i: {k: little * term[i].get(k, 0.0) + (put[i].get(k, 0.0) if put else 0.0) for k in {*term[i], *(put[i] if put else ())}}
        return self.change(sims, [self.run(theta, [add(t, i) for i in range(len(self.recs))]) for t in terms], little)

    def look_up(self):
        found, terms, self.shapes = self.library(self.theta, self.sims), [], {}
        for effect, shapes in found[0].items():
            for s, shape in enumerate(shapes):
                self.shapes[effect, s] = list(range(len(terms), len(terms) + len(shape)))
                terms += [[of[effect][s][k] for of in found] for k in range(len(shape))]
        self.raw = self.columns(self.theta, self.sims, terms)
        self.G = self.project(self.raw)

    def polished(self, shape, c):
        """What is left with the effect in the simulation and the parameters moved along, at best; and the coefficients."""
        raw, given, theta, best = self.raw[:, self.shapes[shape]], self.given, self.theta, None
        step = c
        for _ in range(3):
            theta = np.clip(self.move @ (given - raw @ step), -FAR, FAR)
            found = self.library(theta, self.run(theta))
            terms = [[of[shape[0]][shape[1]][k] for of in found] for k in range(len(c))]
            put = [{k: sum(a * t[i].get(k, 0.0) for a, t in zip(c, terms)) for t in terms for k in t[i]} for i in range(len(self.recs))]
            sims = self.run(theta, put)
            given = self.missing(sims) + self.N @ theta
            if not np.isfinite(given).all():
                break
            raw = self.columns(theta, sims, terms, put)
            step = stlsq(self.project(raw), self.project(given), 0.0)
            c = c + step
            left = self.project(given - raw @ step)
            if physical(shape[0], c) and (best is None or left @ left < best[0] @ best[0]):
                best = left, c
        return best

    def power(self, rows):
        return {k: np.mean(rows[own] ** 2) for k, own in self.kinds.items()}

    def excess(self, rows):
        """Mean square above the noise by kind of rows, and by link what it adds to that of all rows."""
        above, links = {k: max(power - 1, 0) for k, power in self.power(rows).items()}, dict.fromkeys(LINKS.values(), 0.0)
        for kind, own in self.kinds.items():
            links[LINKS[kind.split()[0]]] += above[kind] * np.mean(own)
        return above, links


def windows(t, half):
    """What `WeakPDELibrary.convert_u_dot_integral` does window by window, as a matrix: several times as fast."""
    half, own = max(half, 4.01 * t[1]), pysindy.PolynomialLibrary(degree=1, include_bias=False)
    weak = pysindy.WeakPDELibrary(own, spatiotemporal_grid=t, K=max(20, int(1.5 * t[-1] / half)), H_xt=half)
    inside, weights = [np.asarray(k[0]) for k in weak.inds_k], [-np.asarray(w).ravel() for w in weak.fulltweights]
    ends = np.cumsum([0] + [len(k) for k in inside])
    return csr_array((np.concatenate(weights), np.concatenate(inside), ends), shape=(len(inside), len(t)))


def shapes_that_fit(case, G, z, first=None, so_far=None):
    """Shapes, the best first, with coefficients and rows that are left; beside a first shape, if there is one."""
    small = np.linalg.qr(np.column_stack([G, z]), mode="r")
    beside, fits = case.shapes[first] if first else [], []
    for shape, own in case.shapes.items():
        if first and (shape[0] == first[0] or {shape[0], first[0]} <= {PLAIN, *RICH}):
            continue
        c = stlsq(small[:, beside + own], small[:, -1], 0.0 if first else FAINT)
        if physical(shape[0], c[len(beside) :]) and (not first or physical(first[0], so_far + c[: len(beside)])):
            fits.append((np.sum((small[:, -1] - small[:, beside + own] @ c) ** 2), shape, c))
    return [(shape, c, z - G[:, beside + case.shapes[shape]] @ c) for _, shape, c in sorted(fits, key=lambda f: f[0])]


def decide(case):
    """Verdict and names."""
    power = max(case.power(case.z).values())
    if power < GATE:
        return "nothing-missing", []
    unnamed = ("unexplained" if power > STRANGE else "nothing-missing"), []
    case.look_up()
    by_effect = {}
    for shape, c, left in shapes_that_fit(case, case.G, case.z):
        by_effect.setdefault(shape[0], (shape, c, left))
    tried = {}
    for effect, (shape, c, _) in list(by_effect.items())[:5]:
        if again := case.polished(shape, c):
            tried[effect] = (shape, again[1], again[0])
    if not tried:
        return unnamed
    first = min(tried.values(), key=lambda one: one[2] @ one[2])
    plain = tried.get(PLAIN, by_effect.get(PLAIN))
    if first[0][0] in RICH and plain:
        rich, poor = (case.excess(one[2])[1]["mechanics"] for one in (first, plain))
        first = first if rich < RICHER * poor and poor - rich > SHOWN else plain
    shape, c, left = first
    if not takes(case, case.z, left, HALF):
        return unnamed
    weight = 1 / np.sqrt(1 + (ROUGH * (case.z - left)) ** 2)
    for second, _, least in shapes_that_fit(case, case.G * weight[:, None], left * weight, shape, c):
        if takes(case, left * weight, least, MORE):
            return "missing-physics", [shape[0], second[0]]
    return "missing-physics", [shape[0]]


def takes(case, before, after, share):
    """Whether the link that gains most was above the gate and loses more than a share of its excess."""
    (kinds, old), (_, new) = case.excess(before), case.excess(after)
    link = max(old, key=lambda k: old[k] - new[k])
    seen = any(above > GATE - 1 for kind, above in kinds.items() if LINKS[kind.split()[0]] == link)
    return seen and new[link] < (1 - share) * old[link] and old[link] - new[link] > SHOWN


def diagnose(folder, out):
    try:
        verdict, names = decide(Case(folder))
    except (ValueError, np.linalg.LinAlgError) as error:
        print(f"{folder}: {error}", file=sys.stderr)
        verdict, names = "failed", []
    with open(out, "w") as file:
        json.dump({"schema": "host-sim/diagnosis/1", "verdict": verdict, "findings": [{"effect": name} for name in names]}, file)


def main():
    warm(), play(np.zeros(3), 0.1), stick(np.zeros(3), 0.1), bristle(np.zeros(3), 0.1)
    print(json.dumps(dict(versions=f"pysindy {pysindy.__version__}, numpy {np.__version__}")), flush=True)
    for line in sys.stdin:
        start, computed = time.perf_counter(), time.process_time()
        diagnose(*line.rstrip("\n").split("\t"))
        peak_kb = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM"))
        took = dict(seconds=time.perf_counter() - start, computed=time.process_time() - computed, peak_kb=peak_kb)
        print(json.dumps(took), flush=True)


if __name__ == "__main__":
    main()
