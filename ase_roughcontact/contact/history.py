"""Registry of the entries of a surface's history, which it keeps of earlier steps.

An entry is declared by the code that reads it, such as the steps of a path, also of a
path of your own. A friction law declares its `histories` by its definition: ::

    from ase_roughcontact.contact.history import HistoryEntry, declare

    AGE = declare(HistoryEntry("age", "s", in_frames=True))

    stepper.commit(relaxed, **{AGE.name: age})  # kept from here on
    state.history[AGE.name]  # in the next step

Nothing else is kept. All entries are in the restart file of a path, in double
precision; entries with `in_frames` are also in the frames of its trajectory, in single
precision. A snapshot has all of them.
"""

from ase_roughcontact._util.history import (
    HistoryEntry as HistoryEntry,  # documented with the friction laws
)
from ase_roughcontact._util.history import declare, entry_of, is_entry

__all__ = ["declare", "entry_of", "is_entry"]
