"""Studies: many scenes under many settings, planned on all cores or on a cluster; a row a plan."""
