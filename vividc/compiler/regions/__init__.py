"""From a kernel's regions to their mappings.

In order: `earlier` (what is kept of graphs from stage to stage), `stores` (what constant stores
hold), `homes` (where variables live), `delivery` (how they travel between regions),
`shared_variables` (which ones need one place only), `map_again` (loops again, for fewer bank stalls
and shorter iterations), `map_straight` (straight regions around loops, from under the ends of those
on), `map_regions` (loops, then straight regions, in the time there is).
"""
