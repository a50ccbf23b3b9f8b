"""What would make a program faster, for `vividc compile --explain`: changes of options and of the
source, each planned as if it were made.

In order: `apart` (reads from an array of their own), `request` (what a plan follows from, and plans
of several), `sizes` (that stand in for a user's), `changes` (all that are tried), `search` (what a
longer search could bring), `advise` (what saves enough, ranked).
"""
