"""The limits that a sweep searched for, over the dimension ``search``: one for each point of the other axes.

The runs of a search stand along ``run``, each with the value that it tried, as those of any sweep of pairs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from studies.cubes.variable import ROOT, Column, Variable
from studies.cubes.variables import parameter_variable
from studies.quantities.parameters import Parameter, Value
from studies.runs.results import RunResult
from studies.sweeps.search import LimitOutcome, SearchedLimit, SearchVerdict, decided

SEARCH, PREFIX = "search", "limit_"
VERDICTS = tuple(SearchVerdict)
# States of a run that may have a result later.
UNFINISHED = ("cancelled", "running", "pending", "missing")

Searched = Sequence[tuple[Mapping[str, Value], SearchedLimit]]  # by the values of the other axes

# A record is a ``SearchedLimit``; numbers have the unit of the axis.
_of_search = partial(Variable, dims=(SEARCH,), group=ROOT)

LIMIT = _of_search(
    "limit",
    "middle of the interval in which the searched outcome changes from 0 to 1; NaN: not bracketed",
    lambda limit: limit.value,
    label="limit",
)
LOWER = _of_search(
    "limit_lower",
    "highest value with the outcome 0 below the lowest with 1",
    lambda limit: limit.lower,
    label="limit, lower end",
)
UPPER = _of_search(
    "limit_upper",
    "lowest value with the outcome 1 above the highest with 0",
    lambda limit: limit.upper,
    label="limit, upper end",
)
COUNT = _of_search(
    "limit_runs", "number of runs of the search", lambda limit: len(limit.tried), unit="1", kind="integer"
)
VERDICT = _of_search(
    "limit_verdict",
    "bracketed; non-monotone where a 1 lies below a 0; not bracketed; unfinished",
    lambda limit: limit.verdict,
    kind="flag",
    meanings=VERDICTS,
    label="limit, verdict",
)
REASON = _of_search(
    "limit_reason",
    "reason why there is no limit, or why its interval is wider than asked",
    lambda limit: limit.reason,
    kind="text",
)


def outcome_of(result: RunResult, quantity: str) -> LimitOutcome | str:
    """The outcome of a run by its result, or its state where it has not ended."""
    if result.state in UNFINISHED:
        return "unfinished"
    measured = result.measurements.get(quantity) if result.state == "succeeded" else None
    return decided(measured.value, measured.flags) if measured else None


def columns_of(
    limits: Searched, axis: Parameter, parameters: Mapping[str, Parameter], about: Mapping[str, str]
) -> list[Column]:
    """The variables of limits of an axis with their values; ``about`` are attributes of the limit itself."""
    records = np.empty(len(limits), object)
    records[:] = [limit for _, limit in limits]
    columns: list[Column] = []
    for name in limits[0][0]:
        variable = parameter_variable(parameters[name], (SEARCH,))
        values = np.array([at[name] for at, _ in limits], object)
        label = f"{variable.label} (limit)"
        variable = replace(variable, name=f"{PREFIX}{variable.name}", label=label, group=ROOT)
        columns.append((variable, variable.values(values), {}))
    for variable in (LIMIT, LOWER, UPPER, COUNT, VERDICT, REASON):
        own = variable if variable.unit or variable.kind != "number" else replace(variable, unit=axis.unit)
        columns.append((own, own.values(records), about if variable is LIMIT else {}))
    return columns
