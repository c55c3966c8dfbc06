"""Makes of the trace.mcap of a mission a recording for Rerun, trace.rrd, that opens with a view of the mission: the map
from above with walls, drones and links, the strengths of the links over time, the states of the drones, and the log.

    pip install rerun-sdk mcap-protobuf-support
    python3 to_rerun.py out/demo/trace.mcap
    rerun out/demo/trace.rrd
"""

import struct
import sys
from dataclasses import dataclass
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from rerun.blueprint.encodings import ComponentSourceKind, VisualizerComponentMapping

WALLS, DRONES, LINKS, SCENE, LOG = "/map/walls", "/drones/points", "/drones/links", "/drones", "/log"


@dataclass
class Drone:
    """A drone, or the base."""

    topic: str
    name: str
    colour: list[int]


def topics_with_messages(path):
    with open(path, "rb") as file:
        summary = make_reader(file).get_summary()
    counts = summary.statistics.channel_message_counts
    return {channel.topic for channel in summary.channels.values() if counts.get(channel.id)}


def first_message(path, topic):
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages([topic]):
            return message
    sys.exit(f"{path}: no message on {topic}; give the trace.mcap that `uchain run --out` writes")


def drones_of(scene):
    """The drones under the names of their mission, as the first scene has them."""
    drones = []
    for entity in scene.entities:
        if not entity.texts:
            continue
        number, text = entity.id.removeprefix("drone "), entity.texts[0]
        colour = [round(255 * part) for part in (text.color.r, text.color.g, text.color.b)]
        drones.append(Drone(f"/drone/{number}", text.text.splitlines()[0], colour))
    return drones


def extent(cloud):
    """The middle of the points of a cloud from above, and the larger side of the rectangle around them, m."""
    points = [struct.unpack_from("<ff", cloud.data, at) for at in range(0, len(cloud.data), cloud.point_stride)]
    (west, east), (south, north) = ((min(axis), max(axis)) for axis in zip(*(points or [(0.0, 0.0)])))
    return ((west + east) / 2, (south + north) / 2), max(east - west, north - south, 5.0)


def field_of(message, field, target, visualizer):
    """Lets a visualizer take its input from a field of the messages of an entity."""
    source = {"source_component": f"{message}:message", "selector": f".{field}"}
    mapping = VisualizerComponentMapping(target, ComponentSourceKind.SourceComponent, **source)
    return visualizer.visualizer(mappings=[mapping])


def map_view(walls):
    (x, y), side = extent(walls)
    eye = rrb.EyeControls3D(position=(x, y, 1.3 * side), look_target=(x, y, 0.0), eye_up=(0.0, 1.0, 0.0))
    radii_m = {WALLS: 0.04, LINKS: 0.06, DRONES: 0.15}
    return rrb.Spatial3DView(
        name="Map",
        contents=list(radii_m),
        overrides={topic: rr.Points3D.from_fields(radii=radius) for topic, radius in radii_m.items()},
        spatial_information=rrb.SpatialInformation(target_frame="map"),
        eye_controls=eye,
    )


def series_view(title, message, field, lines):
    """A plot of one field, with a line for each topic."""
    overrides = {
        topic: field_of(message, field, "Scalars:scalars", rr.SeriesLines(names=drone.name, colors=drone.colour))
        for topic, drone in lines.items()
    }
    return rrb.TimeSeriesView(name=title, contents=list(overrides), overrides=overrides)


def blueprint_of(path):
    there = topics_with_messages(path)
    drones = drones_of(first_message(path, SCENE))
    states = {f"{drone.topic}/state": drone for drone in drones}
    links = {f"{drone.topic}/link/back": drone for drone in drones}
    links = {topic: drone for topic, drone in links.items() if topic in there}
    changes = {
        topic: field_of("uchain.DroneState", "state", "StateChange:state", rr.StateChange()) for topic in states
    }
    plot = (
        series_view("Links towards the base, dBm", "uchain.Link", "filtered_dbm", links)
        # Only a chain has links to neighbours.
        if links
        else series_view("Way from the base, m", "uchain.DroneState", "way_m", states)
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            map_view(first_message(path, WALLS)),
            rrb.Vertical(
                plot,
                rrb.StateTimelineView(name="States", contents=list(changes), overrides=changes),
                rrb.TextLogView(name="Log", contents=[LOG]),
            ),
            column_shares=[3, 2],
        ),
        collapse_panels=True,
    )


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: to_rerun.py TRACE.mcap")
    path = Path(sys.argv[1])
    try:
        blueprint = blueprint_of(path)
    except (OSError, McapError) as error:
        sys.exit(f"{path}: {error}; give the trace.mcap that `uchain run --out` writes")
    out = path.with_suffix(".rrd")
    rr.init("uchain")
    rr.save(out, default_blueprint=blueprint)
    rr.log_file_from_path(path)
    print(f"wrote {out}")


if __name__ == "__main__":
    main()
