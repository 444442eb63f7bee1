"""A class's question and its answers as HTML: bars once they are revealed, and the gain."""

from __future__ import annotations

import html

from app.teach.poll import Poll
from app.ui import style
from app.ui.numbers import with_minus


def question_text(poll: Poll, students: int, answered: bool) -> str:
    """The question, and what may be seen of its answers.

    Args:
        poll: the question.
        students: number of those who take part.
        answered: whether to say how many have answered while the answers are hidden.
    """
    text = f"<b>{html.escape(poll.text)}</b>"
    if poll.revealed:
        return style.paragraph(text) + _revealed(poll, students)
    if len(poll.rounds) > 1:
        text += " <i>Second round: talk with your neighbour, then answer again.</i>"
    if poll.asks_place:
        text += " Click or tap a node in the scene."
    text = style.paragraph(text)
    if answered:
        text += style.paragraph(f"{len(poll.answers)} of {students} have answered.")
    return text


def bars(choices: tuple[str, ...], counts: tuple[int, ...], students: int, right: int = -1) -> str:
    """Bar plot of the answers, as HTML; ``right`` is the number of the one to be marked."""
    voted = max(sum(counts), 1)
    rows = "".join(
        '<div style="margin-bottom:7px">'
        f"{'✓ ' if number == right else ''}{html.escape(choice)}: <b>{count}</b>"
        '<div style="height:8px;border-radius:3px;'
        f'background:{style.css(style.POINT)};width:{100 * count / voted:.0f}%"></div></div>'
        for number, (choice, count) in enumerate(zip(choices, counts, strict=True))
    )
    return style.paragraph(f"{rows}{sum(counts)} of {students} have answered.")


def _revealed(poll: Poll, students: int) -> str:
    if poll.asks_place:
        text = style.paragraph(f"{len(poll.answers)} of {students} have answered.")
    else:
        text = bars(poll.choices, poll.counts(), students, poll.right)
    shares = [poll.right_share(number) for number in range(len(poll.rounds))]
    told = [f"{100 * share:.0f} %" for share in shares if share is not None]
    if told:
        gain = poll.gain
        more = "" if gain is None else f" (gain {with_minus(f'{gain:.2f}')} of what was missing)"
        text += style.paragraph(f"Right: {' → '.join(told)}{more}.")
    return text + (style.paragraph(html.escape(poll.why)) if poll.why else "")
