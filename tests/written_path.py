"""Load paths with an output that is given by keywords."""

from dataclasses import fields

from ase_roughcontact import Output, load_path


def written_path(atoms, penetrations=None, **options):
    """Return `load_path` with the attributes of `Output` among its options."""
    names = {field.name for field in fields(Output)} & options.keys()
    output = Output(**{name: options.pop(name) for name in names})
    return load_path(atoms, penetrations=penetrations, output=output, **options)
