"""Tables in Markdown, for the pages of the guide."""


def table(head, rows):
    """Print a table; columns of the head are separated by ``|``."""
    titles = [title.strip() for title in head.split("|")]
    print("|", " | ".join(titles), "|")
    print("|---" * len(titles) + "|")
    for row in rows:
        print("|", " | ".join(map(str, row)), "|")
