"""Entry point in ASE's system of file formats: frames of a path for `ase.io.read`."""

from ase.utils.plugins import ExternalIOFormat

#: Format of ``sweep.traj``; see `read_frames`.
FRAMES = ExternalIOFormat(
    desc="Frames of a path of ase_roughcontact",
    code="+B",
    module="ase_roughcontact.loading.trajectory",
    magic=b"frames of ase_roughcontact",
)
