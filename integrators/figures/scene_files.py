"""Scene files that figures change a little."""


def opened(scene, shape, directory):
    """A copy of a scene file with one more shape, beside links to all that the file may name."""
    for other in scene.parent.iterdir():
        if other.name != scene.name:
            (directory / other.name).symlink_to(other)
    copy = directory / scene.name
    copy.write_text(scene.read_text().replace("</scene>", f"{shape}</scene>"))
    return copy
