"""Fits of forms of laws to measured points, beside published laws of the same form, and whether they decide."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from studies import laws
from studies.fits.fitted import FittedConstant, FittedLaw, FittedRange
from studies.fits.forms import FORMS, Form, columns_of, dimension_of
from studies.fits.measured import MeasuredShots
from studies.laws import Shot
from studies.quantities.least_squares import CONFIDENCE, NotIdentified, Solution, aic, aicc, linear, nonlinear
from studies.quantities.parameters import Plain
from studies.quantities.units import round_quantity

# Forms whose criteria differ by less are not told apart: "substantial support" of Burnham and Anderson (2002), Model
# Selection and Multimodel Inference, 2nd edition, section 2.6 (recalled, not read).
DECIDES = 2.0
# A published law has a form where this form fits its answers this well, relative: round-off of the iteration.
HAS_FORM = 1e-9
# Mean square of residuals that are round-off of constants with twelve digits: exact data have no finite logarithm.
NOTHING_LEFT = 1e-24
TOO_FEW = "not fitted: {points} points, {constants} constants take {needed} or more"
TOO_FEW_TO_COMPARE = "because the points are too few for AICc of forms with another number of constants"


@dataclass(frozen=True)
class Published:
    """Constants of a published law that has the form, for the shots of a fit."""

    title: str
    constants: tuple[float, ...]


@dataclass(frozen=True)
class FittedForm:
    """A form fitted to points, or the reason why not."""

    form: Form
    measured: MeasuredShots
    solution: Solution | None  # in y/d, or in its logarithm
    reason: str = ""
    published: tuple[Published, ...] = ()

    @property
    def constants(self) -> dict[str, FittedConstant]:
        """The constants with their intervals; of a factor exp(c) the interval is that of c."""
        assert self.solution is not None
        read = {}
        columns = zip(self.form.constants, self.solution.constants, self.solution.intervals, strict=True)
        for place, (name, value, reach) in enumerate(columns):
            ends = (value, value - reach, value + reach)
            if self.form.logarithmic and place == 0:
                ends = tuple(math.exp(end) if end < 700.0 else math.inf for end in ends)  # type: ignore[assignment]
            read[name] = FittedConstant(*(_rounded(end) for end in ends))
        return read

    @property
    def values(self) -> list[float]:
        """The constants alone."""
        return [constant.value for constant in self.constants.values()]

    @property
    def residuals(self) -> np.ndarray:
        """MeasuredShots minus fitted size of each point, (points,) in m."""
        ratios = self.form.ratio(columns_of(self.measured.shots), self.values)
        return self.measured.values - ratios * _scales(self.measured)

    @property
    def rms(self) -> float:
        """Root of the mean square of the residuals, m."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def scatter(self) -> float:
        """Relative standard deviation of the points about the fit."""
        assert self.solution is not None
        relative = self.residuals / (self.measured.values - self.residuals)
        return float(np.sqrt((relative**2).sum() / max(1, self.solution.freedom)))

    @property
    def aic(self) -> float:
        """Akaike's criterion without the correction for few points."""
        return aic(self._mean_square, len(self.measured.shots), len(self.form.constants))

    @property
    def aicc(self) -> float:
        """The corrected criterion; infinite where the points are too few for it."""
        return aicc(self._mean_square, len(self.measured.shots), len(self.form.constants))

    @property
    def _mean_square(self) -> float:
        """Of the residuals of the sizes, whatever was fitted: forms are compared under one assumption on errors.

        In units of the sizes' uncertainties, or of the mean size where these are unknown.
        """
        sizes = self.measured.values
        units = np.full(len(sizes), sizes.mean()) if self.measured.errors is None else self.measured.errors
        return max(float(np.mean((self.residuals / units) ** 2)), NOTHING_LEFT)

    @property
    def diameter(self) -> float | None:
        """The projectile's diameter that all points share, m."""
        diameters = _diameters(self.measured.shots)
        return float(diameters[0]) if np.ptp(diameters) <= 1e-9 * diameters[0] else None

    def in_millimetres(self) -> dict[str, float] | None:
        """The constants of the size itself, in mm or mm3; None where the points differ in the projectile's diameter."""
        if self.diameter is None:
            return None
        factor = (1e3 * self.diameter) ** dimension_of(self.measured.quantity)
        return {
            name: constant.value * (factor if name in self.form.multiplied else 1.0)
            for name, constant in self.constants.items()
        }

    def law(self, name: str = "") -> FittedLaw:
        """The fit as a law of its own; its range is that of the points."""
        shots, title = self.measured.shots, self.measured.title
        assert self.solution is not None
        ratios = [shot.thickness_ratio for shot in shots]
        return FittedLaw(
            name=name or f"{title}-{self.form.name}".replace("_", "-"),
            title=f"fit of {title}",
            quantity=self.measured.quantity,
            form=self.form,
            constants=self.constants,
            level=CONFIDENCE,
            points=len(shots),
            scatter=_rounded(self.scatter),
            range=FittedRange(
                speed=_ends([shot.speed for shot in shots]),
                thickness_ratio=_ends(ratios) if np.isfinite(ratios).all() else None,
                length_ratio=_ends([shot.length_ratio for shot in shots]),
                materials=(shots[0].projectile.name, shots[0].target.name),
            ),
            source=self.measured.source,
        )


def forms_of(quantity: str) -> list[Form]:
    """The forms of laws for a quantity."""
    return [form for form in FORMS.values() if quantity in form.quantities]


def fits_of(measured: MeasuredShots, forms: Sequence[Form] | None = None) -> list[FittedForm]:
    """Each form of a quantity fitted to its points."""
    return [fit(measured, form) for form in forms or forms_of(measured.quantity)]


def fit(measured: MeasuredShots, form: Form) -> FittedForm:
    """A form fitted to points, weighted by their uncertainties where all have them."""
    reason = _why_not(measured, form)
    if reason:
        return FittedForm(form, measured, None, reason)
    try:
        errors = None if measured.errors is None else measured.errors / _scales(measured)
        solution = _solved(form, measured.shots, measured.values / _scales(measured), errors)
    except NotIdentified:
        reason = "not fitted: the points do not tell its constants apart"
        return FittedForm(form, measured, None, reason)
    return FittedForm(form, measured, solution, published=tuple(_published(measured, form)))


def _why_not(measured: MeasuredShots, form: Form) -> str:
    """Why a form is not fitted; empty where it is."""
    count, needed = len(measured.shots), len(form.constants) + 2
    if count < needed:
        return TOO_FEW.format(points=count, constants=len(form.constants), needed=needed)
    data = columns_of(measured.shots)
    has_plate = np.isfinite(data.thickness_ratio)
    if form.uses_thickness and not has_plate.all():
        return "not fitted: no plate thickness"
    if not form.uses_thickness and has_plate.any() and not _alike(data.thickness_ratio):
        return "not fitted: the points differ in t/d, which the form does not have"
    if form.uses_thickness and form.nonlinear and _alike(data.thickness_ratio):
        return "not fitted: all points have the same t/d"
    if (data.speed <= form.slowest).any():
        return f"not fitted: it has no value up to {form.slowest:g} km/s"
    if len({(shot.projectile.name, shot.target.name) for shot in measured.shots}) > 1:
        return "not fitted: the points differ in their materials"
    if any(shot.obliquity for shot in measured.shots):
        return "not fitted: forms are for normal impact"
    return ""


def _alike(values: np.ndarray) -> bool:
    return bool(np.ptp(values) <= 1e-9 * abs(values[0]))


def _solved(form: Form, shots: Sequence[Shot], ratios: np.ndarray, errors: np.ndarray | None) -> Solution:
    data = columns_of(shots)
    if form.logarithmic:
        relative = None if errors is None else errors / ratios
        return linear(form.design(data), np.log(ratios) - form.offset(data), relative)
    if not form.nonlinear:
        return linear(form.design(data), ratios, errors)
    exponents = list(form.nonlinear.values())
    first = linear(form.design(data, *exponents), ratios, errors)
    start = np.array([*first.constants, *exponents])
    return nonlinear(lambda constants: form.ratio(data, constants.tolist()), start, ratios, errors)


def _published(measured: MeasuredShots, form: Form) -> Iterator[Published]:
    """The published laws that have a form: it fits their answers for the shots to round-off."""
    shots = measured.shots
    for law in laws.answering(measured.quantity):
        for variant in dict.fromkeys(name for shot in shots for name in law.variants(shot)):
            answers = np.array([law.evaluate(shot, variant).value for shot in shots])
            ratios = answers / _scales(measured)
            if not np.isfinite(ratios).all():
                continue
            try:
                solution = _solved(form, shots, ratios, None)
            except NotIdentified:
                continue
            size = 1.0 if form.logarithmic else float(np.abs(ratios).max())
            if np.abs(solution.residuals).max() <= HAS_FORM * size:
                constants = solution.constants.tolist()
                if form.logarithmic:
                    constants[0] = math.exp(constants[0])
                title = f"{law.title}, {variant}" if variant else law.title
                yield Published(title, tuple(constants))


# ---- comparison ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Ranked:
    """Fits that the criterion compares, the best first."""

    fits: tuple[FittedForm, ...]
    differences: tuple[float, ...]  # of the criterion from the best


def compared(fits: Sequence[FittedForm]) -> list[Ranked]:
    """Fits to the same points in the groups that the criterion can compare.

    Where the points are too few for its correction, forms with the same number of constants have the same, so that
    their difference is that of the criterion without it.
    """
    groups: dict[int, list[FittedForm]] = {}
    for fitted in fits:
        if fitted.solution is not None:
            corrected = math.isfinite(fitted.aicc)
            groups.setdefault(0 if corrected else len(fitted.form.constants), []).append(fitted)
    ranked = []
    for constants, group in groups.items():
        sizes = {fitted.form.name: fitted.aic if constants else fitted.aicc for fitted in group}
        group.sort(key=lambda fitted: sizes[fitted.form.name])
        least = min(sizes.values())
        ranked.append(Ranked(tuple(group), tuple(sizes[fitted.form.name] - least for fitted in group)))
    return ranked


def verdicts(fits: Sequence[FittedForm]) -> list[str]:
    """A sentence for each group of fits that are compared."""
    sentences = []
    groups = compared(fits)
    for ranked in groups:
        if len(ranked.fits) < 2:
            if len(groups) > 1:
                sentences.append(f"{ranked.fits[0].form.title}: not compared, {TOO_FEW_TO_COMPARE}.")
            continue
        best, rest = ranked.fits[0].form.title, ranked.fits[1:]
        near = [
            (fit.form.title, size) for fit, size in zip(rest, ranked.differences[1:], strict=True) if size < DECIDES
        ]
        if near:
            listed = "; ".join(f"{title} {size:.1f}" for title, size in near)
            sentences.append(
                f"The points do not decide: AICc is lowest for {best}, and higher by less than {DECIDES:g} for "
                f"{listed}."
            )
        else:
            size = ranked.differences[1]
            nearest = min(ranked.fits, key=lambda fitted: fitted.rms)
            although = ""
            if nearest is not ranked.fits[0]:
                although = (
                    f" {nearest.form.title} is nearer, with {len(nearest.form.constants)} constants, which "
                    f"{len(nearest.measured.shots)} points do not support."
                )
            sentences.append(
                f"The points favour {best}: AICc of every other form is higher by {size:.1f} or more.{although}"
            )
    return sentences


# ---- sizes ---------------------------------------------------------------------------------------


def _diameters(shots: Sequence[Shot]) -> np.ndarray:
    return np.array([shot.projectile_diameter for shot in shots])


def _scales(measured: MeasuredShots) -> np.ndarray:
    """The projectile's diameter, or its power for the size of a volume."""
    return _diameters(measured.shots) ** dimension_of(measured.quantity)


def _rounded(value: float) -> float:
    return round_quantity(value) if math.isfinite(value) else value


def _ends(values: Sequence[float]) -> tuple[float, float]:
    return (_rounded(min(values)), _rounded(max(values)))


def as_json(fits: Sequence[FittedForm]) -> Mapping[str, object]:
    """Fits to one quantity as plain values, sizes in SI."""
    measured, done = fits[0].measured, [fitted for fitted in fits if fitted.solution is not None]
    differences = {
        id(fit): size for ranked in compared(done) for fit, size in zip(ranked.fits, ranked.differences, strict=True)
    }
    return {
        "quantity": measured.quantity,
        "source": measured.source,
        "weighted": measured.errors is not None,
        "points": [
            {"at": dict(at), "value": value}
            for at, value in zip(measured.places, measured.values.tolist(), strict=True)
        ],
        "left_out": sum(measured.left_out.values()),
        "left_out_by_reason": dict(measured.left_out),
        "fits": [
            dict[str, Plain](form=fitted.form.name, reason=fitted.reason)
            if fitted.solution is None
            else {
                **fitted.law().document(),
                "in_millimetres": fitted.in_millimetres(),
                "rms": fitted.rms,
                "aicc": fitted.aicc if math.isfinite(fitted.aicc) else None,
                "aicc_difference": differences[id(fitted)],
                "published": [
                    {"law": law.title, "constants": dict(zip(fitted.form.constants, law.constants, strict=True))}
                    for law in fitted.published
                ],
            }
            for fitted in fits
        ],
        "verdict": verdicts(fits),
    }
