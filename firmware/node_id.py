"""Takes over the id that ``caramelo flash --id`` left in a file, once, into the joint's stored parameters."""

import os

from .joint_store import BROKEN

NODE_FILE = "/flash/node.txt"


def take_node(joint, path=NODE_FILE):
    """Make the file's id that of the joint, save it and remove the file; return 1 if that was done.

    Parameters that can't be read are left alone, as evidence: then the file stays, and so does the id.
    """
    try:
        with open(path) as file:
            node = int(file.read())
    except (OSError, ValueError):
        return 0
    if joint.loaded == BROKEN or not 1 <= node <= 12:
        return 0
    joint.set_node(node)
    if not joint.parameters.save():
        return 0
    os.remove(path)
    return 1
