"""Description of the package for an index: the README with links that work there."""

import re
from pathlib import Path

from setuptools import setup

#: Address of the sources, such as "https://github.com/owner/name", when it is known.
REPOSITORY = ""
_RELATIVE = r"(?!https?://|#)([^)\s]+)"


def description(readme: str, repository: str = REPOSITORY) -> str:
    """Return the README for an index, where relative links lead nowhere.

    Links and pictures get the address of the repository; without one, pictures and
    their captions are left out, and of links the text is kept.
    """
    if repository:
        pictures = rf"![\1]({repository}/raw/main/\2)"
        readme = re.sub(rf"!\[([^]]*)\]\({_RELATIVE}\)", pictures, readme)
        links = rf"[\1]({repository}/blob/main/\2)"
        return re.sub(rf"(?<!!)\[([^]]*)\]\({_RELATIVE}\)", links, readme)
    readme = re.sub(rf"(?s)!\[[^]]*\]\({_RELATIVE}\)\n\n\*.*?\*\n\n", "", readme)
    return re.sub(rf"\[([^]]*)\]\({_RELATIVE}\)", r"\1", readme)


if __name__ == "__main__":
    setup(
        long_description=description(Path("README.md").read_text(encoding="utf-8")),
        long_description_content_type="text/markdown",
        project_urls={"Repository": REPOSITORY} if REPOSITORY else {},
    )
