"""The paper's tables and figures beside ours: what `vividc reproduce` measures and writes.

In order: `published` (what the paper and others say), `exhibit` (a table or figure, with a verdict
a line), `scenes` (models, photographs, cameras), `frames` (rendered ones, each measured in a
process of its own and kept), `bars` (pictures), `rendered` (exhibits made of frames) and `machine`
(of kernels, products and areas), `page` (HTML), `reproduce`; `child`, which a frame's process runs.
"""

from vividc.paper.exhibit import Exhibit, Line, Verdict
from vividc.paper.reproduce import EXHIBITS, Report, reproduce

__all__ = ["EXHIBITS", "Exhibit", "Line", "Report", "Verdict", "reproduce"]
