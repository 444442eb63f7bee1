"""Studies: many scenes under many settings, planned on all cores or a cluster, one row per plan."""
