"""The form of a new sweep, made from the record of its scenario; its cost, its set-up, and the same request elsewhere.

A child process reads the form (``service.pages.forms``), as it reads the documents of programs. The page comes back
with what it found, so that the form works without scripts; a script asks for the same page while a person writes.
"""

import secrets
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from dataclasses import replace
from types import MappingProxyType
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import RedirectResponse
from starlette.concurrency import run_in_threadpool

from service.api.access import Caller, Submitter
from service.api.browsers import FormFields, check_token
from service.api.dependencies import in_child, submit, submitting
from service.estimates.routes import priced
from service.pages.fields import FieldGroup, FormField, field_of, field_of_key, is_missing, label_of, placed
from service.pages.forms import MORE, OF_DOCUMENT, AskedSweep, asked
from service.pages.page_routes import PageRoutes
from service.pages.rendering import ONCE, SEE_OTHER, idempotency_of, page
from service.records.jobs import KEY_VARIABLE, PRIORITIES, USUAL_PRIORITIES, Keep, Scope
from service.store import Store
from studies import materials, scenarios
from studies.quantities.findings import Findings, InvalidInput, nearest_cure, refusal
from studies.quantities.parameters import Plain, declared, grouped
from studies.scenarios import Scenario
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.schema import keys_of

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("new", 20, router, (("/new", "New"),))

ORDER, SUBMIT = "order", "submit"  # the field that says whether a form is looked at or submitted, and its value
UNPROCESSABLE = 422
# The fields of the document beside those of parameters, in groups.
GROUPS: Mapping[str, tuple[str, ...]] = {
    "Resolution": ("accuracy", "resolution", "offsets"),
    "Name of the sweep": ("title", "name"),
    "Materials of your own": ("materials",),
    "Measured shots beside the runs": ("observations",),
    "How axes are combined, and more of the document": ("combine", "points", "seed", "model_part", MORE),
}
FURTHER = FormField(
    MORE,
    label_of(MORE),
    "further keys in YAML: constants of materials, fitted laws, ends",
    kind="lines",
    placeholder="axes:\n  target.strength.A: [250 MPa, 300 MPa]",
)


@router.get("/new")
def choose_scenario(request: Request, caller: Submitter) -> Response:
    """The scenarios by what people ask, each with its presets."""
    every = sorted(map(scenarios.load, scenarios.names()), key=lambda scenario: scenario.place)
    listed = [(scenario, [*_presets(scenario.name).items()]) for scenario in every]
    return page(request, "new.html", caller, scenarios=listed)


@router.get("/new/{scenario}")
async def show_form(
    request: Request,
    scenario: str,
    caller: Submitter,
    preset: Annotated[str | None, Query()] = None,
    sweep: Annotated[str | None, Query()] = None,
) -> Response:
    """The form, empty or with the values of a preset, a sweep or the address."""
    document = await run_in_threadpool(_beginning, request.app.state.store, scenario, preset, sweep)
    read = await _asked(request, scenario, request.query_params, document)
    return await run_in_threadpool(_form_page, request, caller, read, {})


def _beginning(store: Store, scenario: str, preset: str | None, sweep: str | None) -> Mapping[str, Plain]:
    """The document of a preset or of a sweep, with which a form begins; empty without one."""
    if sweep:
        document = store.sweeps.document(sweep)
        return document if document["scenario"] == scenario else {}
    presets = _presets(scenario)
    if preset and preset not in presets:
        raise refusal("preset", preset, f"a preset of {scenario}", nearest_cure(preset, presets))
    return presets[preset] if preset else {}


async def _asked(
    request: Request,
    scenario: str,
    fields: Mapping[str, str],
    document: Mapping[str, Plain] = MappingProxyType({}),
    *,
    is_submitted: bool = False,
) -> AskedSweep:
    """What a child process says of a form, which begins with a document."""
    known = {*declared(scenarios.load(scenario).parameters), *OF_DOCUMENT}
    written = {name: text for name, text in fields.items() if name in known}
    max_runs = request.app.state.settings.max_runs
    return await in_child(request, asked, scenario, written, dict(document), is_submitted, max_runs)


@router.post("/new/{scenario}", name="submit", dependencies=[Depends(check_token)])
async def read_form(request: Request, scenario: str, caller: Submitter, fields: FormFields) -> Response:
    """Submit the sweep of a form, and show its page; where it is refused or only looked at, the form again."""
    refused = Findings()
    options = refused.attempt(_options, fields) or (0, Keep.FINAL)
    is_submitted = fields.get(ORDER) == SUBMIT and not refused
    async with submitting(request) if is_submitted else nullcontext():
        sweep = await _asked(request, scenario, fields, is_submitted=is_submitted)
        if sweep.expanded is not None:
            once = idempotency_of(fields, sweep.yaml, fields.get("priority"), fields.get("keep"))
            try:
                stored = await submit(request, sweep.expanded, *options, once)
            except InvalidInput as error:
                refused.extend(error.findings)
            else:
                return RedirectResponse(f"/sweeps/{stored.id}", SEE_OTHER)
    sweep = replace(sweep, findings=(*sweep.findings, *refused))
    return await run_in_threadpool(_form_page, request, caller, sweep, fields, options)


def _options(form: Mapping[str, str]) -> tuple[int, Keep]:
    """Priority of a sweep, and the files that it keeps; raises InvalidInput."""
    text = form.get("priority") or "0"
    try:
        priority, keep = int(text), Keep(form.get("keep") or Keep.FINAL)
    except ValueError:
        priority = PRIORITIES.stop
    if priority not in PRIORITIES:
        raise refusal("priority", text, f"a whole number from {PRIORITIES[0]} to {PRIORITIES[-1]}", "write 0")
    return priority, keep


def _form_page(
    request: Request,
    caller: Caller,
    asked: AskedSweep,
    form: Mapping[str, str],
    options: tuple[int, Keep] = (0, Keep.FINAL),
) -> Response:
    scenario = scenarios.load(asked.scenario)
    record = declared(scenario.parameters)
    is_submitted = form.get(ORDER) == SUBMIT
    at = placed(asked.findings, {*record, *OF_DOCUMENT}, MORE)
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
        of_document=[*_of_document(scenario)],
        values=asked.fields,
        findings={name: found for name, found in at.items() if name not in missing},
        missing={name: label_of(name) for name in missing if name},
        asked=asked,
        estimate=None if asked.estimated is None else priced(request, asked.estimated),
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


def _presets(scenario: str) -> dict[str, dict[str, Plain]]:
    """The shipped sweeps of a scenario, by name."""
    documents = ((name, read_yaml(examples.text(name), name)) for name in examples.names())
    return {name: document for name, document in documents if document["scenario"] == scenario}


def _groups(scenario: Scenario, values: Mapping[str, str]) -> Iterator[FieldGroup]:
    """The parameters of a scenario: first those that are required or have a value, then the records that it holds."""
    record = declared(scenario.parameters)
    groups = grouped(scenario.parameters)
    own = {name for name in groups.get("", ()) if record[name].default is not None}
    bodies = {name for name in scenario.materials if not record[name].optional}
    first = [name for name in record if record[name].required or name in own | bodies or values.get(name)]
    yield FieldGroup("Set-up", tuple(field_of(record[name]) for name in first))
    for title, names in groups.items():
        fields = tuple(field_of(record[name]) for name in names if name not in first)
        if fields:
            yield FieldGroup(label_of(title or "further"), fields)


def _of_document(scenario: Scenario) -> Iterator[FieldGroup]:
    """The fields of the keys that a document of the scenario has."""
    fields = {**{name: field_of_key(name, key) for name, key in keys_of(scenario).items()}, MORE: FURTHER}
    for title, names in GROUPS.items():
        yield FieldGroup(title, tuple(fields[name] for name in names if name in fields))
