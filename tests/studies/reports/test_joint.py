"""The joint uncertainty: named parts, the law's scatter, and nothing where the mesh error is unknown."""

import numpy as np
import xarray as xr

from studies.reports.joint import joint_uncertainty

CUBE = xr.Dataset(
    {
        "hole": ("speed", [10.0, 10.0, 10.0, 10.0], {"units": "m"}),
        "hole_reading_uncertainty": ("speed", [3.0, 3.0, 3.0, 3.0]),
        "hole_converged_uncertainty_mesh": ("speed", [3.0, np.nan, 3.0, 3.0]),
        "hole_definition_part": ("speed", [84.0, np.nan, np.nan, 84.0]),
        "hole_model_part": ("speed", [4.0, 4.0, np.nan, 4.0]),
        "hole_by_law": (("speed", "hole_law"), [[24.0, 10.0]] * 4),
        "hole_law_scatter": ("hole_law", [0.5, np.nan]),
        "run_state": ("speed", np.array([0, 0, 0, 1], np.int8)),
    },
    {"speed": [1.0, 2.0, 3.0, 4.0], "hole_law": ["scattered", "silent"]},
)


def test_joint__is_the_root_of_the_squares_of_the_parts_that_there_are() -> None:
    joint = joint_uncertainty(CUBE, "hole", "scattered")
    assert list(joint.parts) == ["numerical", "definition", "model", "scatter"]
    np.testing.assert_allclose(joint.total, [85.0, np.nan, np.hypot(3.0, 12.0), np.nan])
    np.testing.assert_array_equal(joint.numerics_only, [False, False, True, True])


def test_joint__of_a_law_without_published_scatter_has_none() -> None:
    joint = joint_uncertainty(CUBE, "hole", "silent")
    assert np.isnan(joint.parts["scatter"]).all()
    assert joint.total[0] == joint_uncertainty(CUBE, "hole").total[0] == np.hypot(5.0, 84.0)


def test_joint__without_a_mesh_error_judges_nothing() -> None:
    single = CUBE.drop_vars("hole_converged_uncertainty_mesh")
    assert np.isnan(joint_uncertainty(single, "hole").total).all()
