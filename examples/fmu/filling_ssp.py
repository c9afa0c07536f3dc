"""A reservoir fills a cylinder through a valve: two FMUs and their parameters as one SSP archive (SSP 1.0).

    pneutherm fmu model.toml -o Cylinder.fmu           # any model file
    pneutherm fmu model.toml -o Reservoir.fmu          # the same, or another
    python examples/fmu/filling_ssp.py Reservoir.fmu Cylinder.fmu -o Filling.ssp

The cylinder's supply port takes the reservoir's pressure and temperature and solves the flow with the gas; the reservoir
gives off what the port took. What differs from the FMUs' start values is in an SSV for each, bound to its component, all under
the name `initialValues`. Nothing in it is more than plain SSD and SSV: no transformations, no mappings.
"""

import argparse
import pathlib
import zipfile
from xml.sax.saxutils import quoteattr

SPACE = "http://ssp-standard.org/SSP1/SystemStructure"
PARAMETERS = "initialValues"

# What each component starts with, SI units: a reservoir of half a litre at 7 bar, a valve of 0.2 l/(s bar) before the cylinder.
START = {
    "Reservoir": {"deadVolume": 5e-4, "initialPressure": 7e5},
    "Cylinder": {"initialPressure": 1.013e5, "supplyPortConductance": 2e-9},
}
# From an output to an input.
CONNECTIONS = [
    ("Reservoir.pressure", "Cylinder.supplyPortPressure"),
    ("Reservoir.temperature", "Cylinder.supplyPortTemperature"),
    ("Cylinder.supplyPortMassFlow", "Reservoir.massFlowOut"),
]
# Outputs that are for whoever watches.
WATCHED = {"Reservoir": ["mass", "pressure"], "Cylinder": ["mass", "pressure"]}


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
        f'xmlns:ssv="{SPACE}ParameterValues" version="1.0" name="Filling">'
    )
    lines += ['  <ssd:System name="Filling">', "    <ssd:Elements>"]
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
    lines += ["    </ssd:Connections>", "  </ssd:System>", '  <ssd:DefaultExperiment startTime="0" stopTime="3"/>']
    return "\n".join([*lines, "</ssd:SystemStructureDescription>", ""])


def parameters(values):
    """An SSV with these values."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    lines.append(f'<ssv:ParameterSet xmlns:ssv="{SPACE}ParameterValues" version="1.0" name="{PARAMETERS}">')
    lines.append("  <ssv:Parameters>")
    for name, value in values.items():
        lines.append(f'    <ssv:Parameter name="{name}"><ssv:Real value="{value!r}"/></ssv:Parameter>')
    return "\n".join([*lines, "  </ssv:Parameters>", "</ssv:ParameterSet>", ""])


def write(reservoir, cylinder, path):
    """Writes the archive."""
    fmus = {"Reservoir": pathlib.Path(reservoir), "Cylinder": pathlib.Path(cylinder)}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        sources = {component: f"resources/{fmu.name}" for component, fmu in fmus.items()}
        archive.writestr("SystemStructure.ssd", structure(sources))
        for component, fmu in fmus.items():
            archive.writestr(f"resources/{component}.ssv", parameters(START[component]))
            archive.write(fmu, sources[component])


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("reservoir", help="FMU of the reservoir")
    options.add_argument("cylinder", help="FMU of the cylinder, of another file name")
    options.add_argument("-o", "--output", default="Filling.ssp", help="the archive")
    given = options.parse_args()
    if pathlib.Path(given.reservoir).name == pathlib.Path(given.cylinder).name:
        options.error("the two FMUs need file names of their own: importers tell them apart by these")
    write(given.reservoir, given.cylinder, given.output)
