"""The lessons that come along, read once for all files that test them."""

from __future__ import annotations

from app.teach.lesson_file import load_lessons

LESSONS = load_lessons()
