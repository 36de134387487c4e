"""Constants of a material from Taylor bars that were shot; no service is needed."""

from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands import SHOTS, Commands
from service.cli.commands.computing import compute
from service.cli.options import SUCCESS, Out, folder_of

app = typer.Typer()
COMMANDS = Commands("calibrating", SHOTS, app, place=1)

BARS = "bars"  # folder of the computed bars, inside that of the calibration


@app.command()
def calibrate(
    shots: Annotated[
        str, typer.Argument(metavar="SHOTS", help="A CSV file of Taylor bars, or a published table by name.")
    ],
    material: Annotated[str, typer.Option(metavar="NAME", help="The material of the bars, of Johnson-Cook strength.")],
    out: Out,
    leave_out: Annotated[
        bool, typer.Option("--leave-out", help="Also predict each series from the others: a minute for each.")
    ] = False,
) -> None:
    """Calibrate Johnson-Cook constants to Taylor bars, with their uncertainty. Needs the extra 'calibrate'.

    A hundred bars are computed first, within a few minutes; repeated, it takes them from the folder. It writes
    calibration.nc, material.toml, materials.yaml for a sweep, and calibration.png.
    """
    from studies import materials
    from studies.cubes.opening import whole_cube
    from studies.fits.calibration import results
    from studies.fits.calibration.design import prior_of, sweep_of
    from studies.fits.calibration.emulator import emulator_of
    from studies.fits.calibration.picture import draw
    from studies.fits.calibration.posterior import Calibration, check_extras, posterior_of
    from studies.fits.calibration.prediction import leave_series_out, predict
    from studies.fits.calibration.shots import read_shots

    check_extras()
    metal = materials.load(material)
    strains = read_shots(shots, metal)
    document = sweep_of(metal, strains)
    folder = folder_of(out)
    compute(document, BARS, folder_of(folder / BARS), keep="numbers")
    cube = whole_cube(folder / BARS)
    emulators = {name: emulator_of(cube, strains.diameter, name) for name in strains.names}
    calibration = Calibration(strains, emulators, prior_of(metal))
    posterior = posterior_of(calibration)
    predicted = predict(posterior, strains)
    print(f"{metal.name} from {shots}")
    for sentence in results.sentences(posterior, predicted):
        print(f"  {sentence}")
    if leave_out:
        for sentence in results.sentences_left_out(leave_series_out(calibration)):
            print(f"  {sentence}", flush=True)
    for file in results.write(folder, metal, posterior, predicted, Path(shots).stem):
        print(f"written: {file}")
    print(f"written: {draw(posterior, predicted, folder / 'calibration.png')}")
    raise typer.Exit(SUCCESS)
