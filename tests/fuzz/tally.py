"""What has become of a search's programs so far: counts, kept in a file so that it can go on."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

VERDICTS = ("agrees", "refused", "differs", "crashes")


@dataclass
class Tally:
    """Counts of a search.

    Attributes
    ----------
    next_seed
        The first seed that has not run; None: none has.
    counts
        Programs by verdict, and by how the simulator was a witness.
    features
        Programs that agree, by what is in them.
    reasons, examples
        Refusals by reason, and the first seed of each.
    finds
        Seeds of programs that differ or crash.
    since
        Programs since the last find.
    seconds
        How long it took.
    """

    next_seed: int | None = None
    counts: Counter[str] = field(default_factory=Counter)
    features: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    examples: dict[str, int] = field(default_factory=dict)
    finds: list[int] = field(default_factory=list)
    since: int = 0
    seconds: float = 0.0

    @property
    def programs(self) -> int:
        """How many were run."""
        return sum(self.counts[kind] for kind in VERDICTS)

    def add(self, seed: int, kind: str, text: str, how: str, features: set[str]) -> None:
        """Count a program: its verdict, a refusal's reason, how it was simulated, what is in it."""
        self.next_seed = seed + 1
        self.counts.update([kind, *([how] if how else [])])
        self.since += 1
        if kind in ("differs", "crashes"):
            self.since = 0
            self.finds.append(seed)
        elif kind == "refused":
            self.reasons.update([text])
            self.examples.setdefault(text, seed)
        else:
            self.features.update(features)

    def summary(self) -> str:
        """Programs, finds, and how many programs that agree hold each feature, in one line."""
        known = ", ".join(f"{name}: {n}" for name, n in self.features.most_common())
        found = f"{len(self.finds)} finds" + f" (seeds {self.finds})" * bool(self.finds)
        rate = self.programs / self.seconds if self.seconds else 0.0
        counted = ", ".join(f"{n} {kind}" for kind, n in self.counts.most_common())
        return (
            f"{self.programs} programs, {found}, the last {self.since} without one; {counted}; "
            f"{rate:.2f}/s; features of those that agree: {known or 'none'}"
        )

    def to_json(self) -> str:
        """All of it, and the number of programs."""
        return json.dumps({"programs": self.programs, **vars(self)}, sort_keys=True)

    @classmethod
    def from_json(cls, text: str) -> Tally:
        """What `to_json` wrote."""
        read = json.loads(text)
        del read["programs"]
        for name in ("counts", "features", "reasons"):
            read[name] = Counter(read[name])
        return cls(**read)

    @classmethod
    def kept_in(cls, file: Path | None) -> Tally:
        """The tally of a search that goes on, or a new one."""
        if file is None or not file.exists():
            return cls()
        return cls.from_json(file.read_text(encoding="utf-8"))

    def keep_in(self, file: Path | None) -> None:
        """Write it, whole or not at all."""
        if file is not None:
            part = file.with_name(f"{file.name}.part")
            part.write_text(self.to_json(), encoding="utf-8")
            part.replace(file)
