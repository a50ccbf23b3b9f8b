"""From a kernel's regions to their mappings.

In order: `earlier` (what is kept of graphs from stage to stage), `stores` (what constant stores
hold), `turns` (which regions hardly ever run), `homes` (where variables live), `delivery` (how they
travel between regions), `shared_variables` (which ones need one place only), `map_again` (loops
again, for fewer bank stalls and shorter iterations), `one_straight` (a straight region between the
loops next to it, which end and begin meanwhile), `map_straight` (all of a kernel), `map_regions`
(loops, then straight regions, in the time there is).
"""
