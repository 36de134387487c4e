"""The form of a new sweep, made from the record of its scenario; its cost, its set-up, and the same request elsewhere.

A child process reads the form (``service.pages.forms``), as it reads the documents of programs. The page comes back
with what it found, so that the form works without scripts; a script asks for the same page while a person writes.
"""

import secrets
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import nullcontext
from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse

from service.api.access import Caller, Submitter
from service.api.browsers import ONCE, FormFields, check_token, idempotency_of
from service.api.dependencies import AppSettings, AppStore, read_content, submission_of, submitting
from service.api.routes import sweeps
from service.api.schemas import EstimateModel, example_sweeps
from service.pages.fields import FieldGroup, FormField, field_of, is_missing, label_of, placed
from service.pages.forms import COUNTS, MORE, WORDS, AskedSweep, asked
from service.pages.page_routes import PageRoutes
from service.pages.rendering import SEE_OTHER, page
from service.records.jobs import KEY_VARIABLE, PRIORITIES, USUAL_PRIORITIES, Keep, Scope
from studies import materials, scenarios
from studies.quantities.findings import InvalidInput, nearest_cure, refusal
from studies.quantities.parameters import declared, grouped
from studies.scenarios import Scenario
from studies.sweeps.accuracy import ACCURACY, USUAL, in_percent
from studies.sweeps.reading import COMBINATIONS, MODEL_PARTS, OFFSET, RESOLUTION

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
PAGE = PageRoutes("new", 20, router, (("/new", "New"),))

ORDER, SUBMIT = "order", "submit"  # the field that says whether a form is looked at or submitted, and its value
UNPROCESSABLE = 422


OF_DOCUMENT = (
    FieldGroup(
        "Resolution",
        (
            FormField(
                "accuracy",
                "Accuracy",
                f"mesh error of what is measured, in per cent or by name ({', '.join(ACCURACY)}): the cells of each "
                f"point follow from it; {in_percent(USUAL)} where no resolution is stated",
                placeholder=in_percent(USUAL),
            ),
            FormField(
                "resolution",
                "Resolution",
                "in place of an accuracy: cells across the projectile or bar, one number or several: 16, 24, 32",
            ),
            FormField(
                "offsets",
                "Grid offsets",
                "runs at each resolution, the grid shifted by a part of a cell from one to the next; their scatter is "
                "part of the error bar",
            ),
        ),
        is_open=True,
    ),
    FieldGroup(
        "Name of the sweep",
        (
            FormField("title", "Title", "stands above the report"),
            FormField("name", "Name", "names files; by default the scenario"),
        ),
        is_open=True,
    ),
    FieldGroup(
        "Materials of your own",
        (
            FormField(
                "materials",
                "Materials",
                "in YAML, by name; a base gives all that you leave out, and fields above may then name them",
                "lines",
                placeholder="my-alloy:\n  base: al-6061-t6\n  strength:\n    A: 300 MPa",
            ),
        ),
    ),
    FieldGroup(
        "Measured shots beside the runs",
        (
            FormField(
                "observations",
                "Shots",
                "the name of a table that ships (see Shots), or your own as CSV: paste it, or choose its file",
                "lines",
                placeholder="speed [km/s],hole_diameter [mm],source\n6.18,27.5,my notebook",
            ),
        ),
    ),
    FieldGroup(
        "How axes are combined, and more of the document",
        (
            FormField(
                "combine",
                "Combine",
                "every value with every other is grid; zip takes them in pairs",
                "choice",
                choices=COMBINATIONS,
            ),
            FormField("points", "Points", "of axes that are sampled between two ends: 4 km/s to 8 km/s"),
            FormField("seed", "Seed", "of sampled points"),
            FormField(
                "model_part",
                "Uncertainty of the models",
                "due to strength, failure and equation of state, stated beside the error bar: stored from earlier "
                "studies, or screened by runs of this sweep with other models",
                "choice",
                choices=MODEL_PARTS,
            ),
            FormField(
                MORE,
                "More",
                "further keys in YAML: constants of materials, fitted laws, ends",
                "lines",
                placeholder="axes:\n  target.strength.A: [250 MPa, 300 MPa]",
            ),
        ),
    ),
)

# The parameter of a scenario that a field sets.
NEEDED = {"resolution": RESOLUTION, "offsets": OFFSET}


@router.get("/new")
def choose_scenario(request: Request, caller: Submitter) -> Response:
    """The scenarios, each with its presets."""
    listed = [(scenarios.load(name), [*_presets(name).items()]) for name in scenarios.names()]
    return page(request, "new.html", caller, scenarios=listed)


# --- the form -------------------------------------------------------------------------------------


def _beginning(
    scenario: str,
    form: FormFields,
    store: AppStore,
    preset: Annotated[str | None, Query()] = None,
    sweep: Annotated[str | None, Query()] = None,
) -> Mapping[str, Any]:
    """The document with which a form begins: that of a preset or of a sweep; of a form that was sent, none."""
    if form or not (preset or sweep):
        return {}
    if sweep:
        document: Mapping[str, Any] = store.sweeps.document(sweep)
        return document if document["scenario"] == scenario else {}
    presets = _presets(scenario)
    if preset not in presets:
        raise refusal("preset", preset, f"a preset of {scenario}", nearest_cure(preset, presets))
    return presets[preset]


async def _asked(
    request: Request,
    scenario: str,
    form: FormFields,
    _: Submitter,
    document: Annotated[Mapping[str, Any], Depends(_beginning)],
) -> AsyncIterator[AskedSweep]:
    """The sweep of a form that was sent, or of the document with which a page begins, read by a child process."""
    known = _names(scenarios.load(scenario))
    fields = {name: text for name, text in (form or request.query_params).items() if name in known}
    content = {"fields": {**fields, "scenario": scenario}, "document": document, "submit": form.get(ORDER) == SUBMIT}
    async with submitting(request) if content["submit"] else nullcontext():
        yield await read_content(request, content, asked)


AskedForm = Annotated[AskedSweep, Depends(_asked, scope="function")]


def _estimate(request: Request, asked: AskedForm, store: AppStore, settings: AppSettings) -> EstimateModel | None:
    """The cost of the sweep of a form; None of one that is refused, or submitted."""
    return None if asked.estimated is None else sweeps.estimate_sweep(asked.estimated, store, settings, request)


FormEstimate = Annotated[EstimateModel | None, Depends(_estimate)]


@router.get("/new/{scenario}")
def show_form(request: Request, caller: Submitter, asked: AskedForm, estimate: FormEstimate) -> Response:
    """The form, empty or with the values of a preset, a sweep or the address."""
    return _form_page(request, caller, asked, estimate, {})


@router.post("/new/{scenario}", dependencies=[Depends(check_token)])
def read_form(
    request: Request,
    caller: Submitter,
    form: FormFields,
    asked: AskedForm,
    estimate: FormEstimate,
    store: AppStore,
    settings: AppSettings,
) -> Response:
    """Submit the sweep of a form, and show its page; where it is refused or only looked at, the form again."""
    options = (0, Keep.FINAL)
    try:
        options = _options(form)
        if asked.expanded is not None:
            once = idempotency_of(form, asked.yaml, form.get("priority"), form.get("keep"))
            submission = submission_of(settings, caller, asked.expanded, *options, once)
            return RedirectResponse(f"/sweeps/{store.sweeps.create(submission).id}", SEE_OTHER)
    except InvalidInput as error:
        asked = replace(asked, findings=(*asked.findings, *error.findings))
    return _form_page(request, caller, asked, estimate, form, options)


def _options(form: Mapping[str, str]) -> tuple[int, Keep]:
    """Priority of a sweep, and the files that it keeps; raises InvalidInput."""
    priority, keep = form.get("priority") or "0", form.get("keep") or Keep.FINAL
    if keep not in set(Keep):
        raise refusal("keep", keep, f"one of {', '.join(Keep)}", "choose one")
    is_number = len(priority) <= len(str(PRIORITIES[0])) and priority.removeprefix("-").isdecimal()
    if not is_number or int(priority) not in PRIORITIES:
        raise refusal("priority", priority, f"a whole number from {PRIORITIES[0]} to {PRIORITIES[-1]}", "write 0")
    return int(priority), Keep(keep)


def _form_page(
    request: Request,
    caller: Caller,
    asked: AskedSweep,
    estimate: EstimateModel | None,
    form: Mapping[str, str],
    options: tuple[int, Keep] = (0, Keep.FINAL),
) -> Response:
    scenario = scenarios.load(asked.fields["scenario"])
    is_submitted = form.get(ORDER) == SUBMIT
    at = placed(asked.findings, _names(scenario), MORE)
    missing = {} if is_submitted else {name: found for name, found in at.items() if is_missing(found)}
    state = request.app.state
    return page(
        request,
        "ask.html",
        caller,
        status=UNPROCESSABLE if is_submitted else 200,
        scenario=scenario,
        presets=_presets(scenario.name),
        groups=[*_groups(scenario, asked.fields)],
        values=asked.fields,
        findings={name: found for name, found in at.items() if name not in missing},
        missing={name: label_of(name) for name in missing if name},
        asked=asked,
        estimate=estimate,
        workers=state.engine.workers() or state.settings.workers,
        names=sorted({*materials.names(), *asked.own_materials}),
        options={"priority": options[0], "keep": options[1]},
        keeps=[*Keep],
        priorities=PRIORITIES if caller.may(Scope.ADMIN) else USUAL_PRIORITIES,
        once=form.get(ONCE) or secrets.token_urlsafe(),
        order=ORDER,
        address=str(request.base_url).rstrip("/"),
        key_variable=KEY_VARIABLE if caller.name else "",
    )


def _presets(scenario: str) -> dict[str, dict[str, Any]]:
    """The shipped sweeps of a scenario, by name."""
    return {name: each["value"] for name, each in example_sweeps().items() if each["value"]["scenario"] == scenario}


# --- fields ---------------------------------------------------------------------------------------


def _names(scenario: Scenario) -> set[str]:
    """The fields of a sweep's document."""
    return {*declared(scenario.parameters), *WORDS, *COUNTS, "resolution", "materials", MORE}


def _groups(scenario: Scenario, values: Mapping[str, str]) -> Iterable[FieldGroup]:
    """The groups of fields: first what is required or has a value, last what the records of the scenario hold else."""
    record = declared(scenario.parameters)
    groups = grouped(scenario.parameters)
    own = {name for name in groups.get("", ()) if record[name].default is not None}
    bodies = {name for name in scenario.materials if not record[name].optional}
    first = [name for name in record if record[name].required or name in own | bodies or values.get(name)]
    yield FieldGroup("Set-up", tuple(field_of(record[name]) for name in first), is_open=True)
    absent = {name for name, parameter in NEEDED.items() if parameter not in record}
    absent |= set() if scenario.accurate else {"accuracy"}
    for group in OF_DOCUMENT:
        fields = tuple(each for each in group.fields if each.name not in absent)
        is_open = group.is_open or any(values.get(each.name) for each in fields)
        if fields:
            yield FieldGroup(group.title, fields, is_open)
    for title, names in groups.items():
        fields = tuple(field_of(record[name]) for name in names if name not in first)
        if fields:
            yield FieldGroup(label_of(title or "further"), fields)
