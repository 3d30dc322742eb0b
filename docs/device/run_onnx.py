"""narx.onnx with onnxruntime alone.

Reads rows "interval_s,sagittal,frontal,transverse" (s, rad/s; nan where lost) and writes the three
angles (rad), their standard deviations (rad) and the quality.
"""

import json
import sys

import numpy as np
import onnxruntime

options = onnxruntime.SessionOptions()
options.log_severity_level = 3
session = onnxruntime.InferenceSession(sys.argv[1], options, providers=["CPUExecutionProvider"])
about = json.loads(session.get_modelmeta().custom_metadata_map["narx"])
numbers = {"double": np.float64, "float": np.float32}[about["precision"]]
rows = np.loadtxt(sys.stdin, numbers, delimiter=",", ndmin=2)
state = np.array([about["start_state"]], numbers)  # an unknown start pose
for first in range(0, len(rows), 100):
    block = rows[first : first + 100]  # of any length: here a second
    feed = {"axis_rates": block[None, :, 1:], "interval_s": block[None, :, 0], "state": state}
    angles, state, std_rad, quality = session.run(None, feed)
    for values in zip(angles[0], std_rad[0], quality[0], strict=True):
        print(",".join(f"{value:.17g}" for value in np.hstack(values)))
loaded = {name.split(".")[0] for name in sys.modules}
assert not loaded & {"narx", "torch"}, "onnxruntime is all that this needs"
