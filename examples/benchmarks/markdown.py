"""Tables in Markdown, for the pages of the guide."""

import re


def table(head, rows):
    """Print a table; columns of the head are separated by ``|``."""
    titles = [title.strip() for title in head.split("|")]
    print("|", " | ".join(titles), "|")
    print("|---" * len(titles) + "|")
    for row in rows:
        print("|", " | ".join(map(str, row)), "|")


def order(value):
    """Return a number with one digit, such as 2e-7, or 0."""
    if value == 0.0 or 1.0 <= abs(value) < 10.0:
        return f"{value:.0f}"
    return re.sub(r"e([-+])0*", r"e\1", f"{value:.0e}")


def ends(values, form=order):
    """Return the range of numbers, each as a text of a form."""
    least, most = form(min(values)), form(max(values))
    return least if least == most else f"{least} to {most}"
