"""A servo cylinder as one SSP archive (SSP 1.0): the FMUs of its two sides and of its piston, with their parameters.

    pip install fmpy pythonfmu
    pneutherm fmu model.toml -o CapSide.fmu            # any model file
    pneutherm fmu rod_side.toml -o RodSide.fmu         # the same with rod_m
    python examples/fmu/servo_ssp.py CapSide.fmu RodSide.fmu -o ServoCylinder.ssp

The same cylinder as in `servo_cylinder.py`; `piston.py` is its piston, valve and controller. Position and velocity come
from the piston together; `strokeInput`, which the script uses instead, is an enumeration, and ecos sets none. The valve
opens a port of each chamber, and the flow is solved there with the gas. What differs from the FMUs' start values is in an SSV for each, bound to
its component, all under the name `initialValues`. Nothing in it is more than plain SSD and SSV: no transformations, no
mappings, so that a master needs to know no more than outputs that become inputs.
"""

import argparse
import pathlib
import tempfile
import zipfile
from xml.sax.saxutils import quoteattr

import servo_cylinder as servo

SPACE = "http://ssp-standard.org/SSP1/SystemStructure"
PARAMETERS = "initialValues"

# What each component starts with, SI units.
START = {
    "CapSide": servo.REST,
    "RodSide": servo.REST,
    "Piston": {
        "mass": servo.MASS_KG,
        "friction": servo.FRICTION_N_S_PER_M,
        "stroke": servo.STROKE_M,
        "target": servo.TARGET_M,
        "conductance": servo.CONDUCTANCE,
    },
}
# From an output to an input.
CONNECTIONS = [
    ("CapSide.force", "Piston.capForce"),
    ("RodSide.force", "Piston.rodForce"),
    ("Piston.capPosition", "CapSide.position"),
    ("Piston.capVelocity", "CapSide.velocity"),
    ("Piston.rodPosition", "RodSide.position"),
    ("Piston.rodVelocity", "RodSide.velocity"),
    ("Piston.capSupply", "CapSide.supplyPortConductance"),
    ("Piston.capExhaust", "CapSide.exhaustPortConductance"),
    ("Piston.rodSupply", "RodSide.supplyPortConductance"),
    ("Piston.rodExhaust", "RodSide.exhaustPortConductance"),
]
# Outputs that are for whoever watches.
WATCHED = {"CapSide": ["pistonPosition", "pressure"], "RodSide": ["pressure"], "Piston": ["capVelocity"]}


def connectors(component):
    """The component's connectors by name: what is connected, and what is watched."""
    kinds = {name: "output" for name in WATCHED[component]}
    for begin, end in CONNECTIONS:
        for connector, kind in ((begin, "output"), (end, "input")):
            owner, name = connector.split(".")
            if owner == component:
                kinds[name] = kind
    return kinds


def structure(sources):
    """SystemStructure.ssd, for FMUs at these places in the archive."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    lines.append(
        f'<ssd:SystemStructureDescription xmlns:ssc="{SPACE}Common" xmlns:ssd="{SPACE}Description" '
        f'xmlns:ssv="{SPACE}ParameterValues" version="1.0" name="ServoCylinder">'
    )
    lines += ['  <ssd:System name="ServoCylinder">', "    <ssd:Elements>"]
    for component, source in sources.items():
        lines.append(f'      <ssd:Component name="{component}" type="application/x-fmu-sharedlibrary" source={quoteattr(source)}>')
        lines.append("        <ssd:Connectors>")
        for name, kind in connectors(component).items():
            lines.append(f'          <ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>')
        lines.append("        </ssd:Connectors>")
        lines.append("        <ssd:ParameterBindings>")
        lines.append(f'          <ssd:ParameterBinding source="resources/{component}.ssv"/>')
        lines += ["        </ssd:ParameterBindings>", "      </ssd:Component>"]
    lines += ["    </ssd:Elements>", "    <ssd:Connections>"]
    for begin, end in CONNECTIONS:
        (a, output), (b, taken) = begin.split("."), end.split(".")
        lines.append(
            f'      <ssd:Connection startElement="{a}" startConnector="{output}" endElement="{b}" endConnector="{taken}"/>'
        )
    lines += ["    </ssd:Connections>", "  </ssd:System>", f'  <ssd:DefaultExperiment startTime="0" stopTime="{servo.DURATION_S:g}"/>']
    return "\n".join([*lines, "</ssd:SystemStructureDescription>", ""])


def parameters(values):
    """An SSV with these values."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    lines.append(f'<ssv:ParameterSet xmlns:ssv="{SPACE}ParameterValues" version="1.0" name="{PARAMETERS}">')
    lines.append("  <ssv:Parameters>")
    for name, value in values.items():
        lines.append(f'    <ssv:Parameter name="{name}"><ssv:Real value="{value!r}"/></ssv:Parameter>')
    return "\n".join([*lines, "  </ssv:Parameters>", "</ssv:ParameterSet>", ""])


def piston(folder):
    """Builds the piston's FMU in this folder."""
    from pythonfmu.builder import FmuBuilder

    return FmuBuilder.build_FMU(pathlib.Path(__file__).with_name("piston.py"), dest=folder)


def write(cap_side, rod_side, path):
    """Writes the archive."""
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        fmus = {"CapSide": pathlib.Path(cap_side), "RodSide": pathlib.Path(rod_side), "Piston": piston(folder)}
        sources = {component: f"resources/{fmu.name}" for component, fmu in fmus.items()}
        archive.writestr("SystemStructure.ssd", structure(sources))
        for component, fmu in fmus.items():
            archive.writestr(f"resources/{component}.ssv", parameters(START[component]))
            archive.write(fmu, sources[component])


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("cap_side", help="FMU of the cap side")
    options.add_argument("rod_side", help="FMU of the rod side, of another file name")
    options.add_argument("-o", "--output", default="ServoCylinder.ssp", help="the archive")
    given = options.parse_args()
    if pathlib.Path(given.cap_side).name == pathlib.Path(given.rod_side).name:
        options.error("the two FMUs need file names of their own: importers tell them apart by these")
    write(given.cap_side, given.rod_side, given.output)
