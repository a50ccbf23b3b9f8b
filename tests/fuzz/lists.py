"""A list in a random kernel, which statements here and there make longer and shorter."""

from __future__ import annotations

from random import Random

STATEMENTS = (
    "made.append(np.int64(s & 63))",
    "made.append(np.int64(s & 63))",
    "made.append(np.int64(k & 7))",
    "made.insert(s & 3, np.int64(-7))",
    "made[s % len(made)] = np.int64(s & 31)",
    "made[-1] = made[0] ^ made[k % len(made)]",
    "s = np.int32(s ^ made[k % len(made)])",
    "s = np.int32(made[s % len(made)])",
    "s = np.int32(made.pop() if len(made) > 1 else s)",
    "s = np.int32(made.pop(0) if len(made) > 2 else s)",
    "made.reverse()",
    "s = np.int32(s + np.array(made).sum())",
    "s = np.int32(s ^ (made.index(made[-1]) + made.count(made[0])))",
)
ENDS = (
    "for v in made: s = np.int32(s ^ v)",
    "s = np.int32(s ^ np.array([v for v in made if v > 2]).sum())",
    "made.sort(); s = np.int32(s ^ made[len(made) // 2])",
    "rest = made[1:] + [np.int64(5)]; s = np.int32(s ^ rest[-1] ^ rest[0])",
)
_OTHERS = ("else", "elif", "break", "continue", "return", "raise")


def with_list(random: Random, body: str) -> str:
    """The body with a list of int64, which holds at least one element at any time."""
    lines = body.splitlines()
    places = [n for n, line in enumerate(lines) if not line.strip().startswith(_OTHERS)]
    if not places or not lines[-1].strip().startswith("return"):
        return body
    chosen = random.choices(places, k=random.randint(1, 4))
    for place in sorted(chosen, reverse=True):
        line = lines[place]
        indent = line[: len(line) - len(line.lstrip())]
        lines.insert(place, indent + random.choice(STATEMENTS))
    lines.insert(len(lines) - 1, "    " + random.choice(ENDS))
    return "\n".join(["    made = [np.int64(3)]", *lines, ""])
