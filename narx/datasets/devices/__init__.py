"""Descriptions of devices, one YAML file each; see `narx.datasets.device_layouts`."""
