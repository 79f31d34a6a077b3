# SPDX-License-Identifier: Apache-2.0
"""Severities of leaks, from the least, with their colours."""

from .. import style

COLOURS = {"minor": style.BLUE, "moderate": style.ORANGE, "severe": style.VERMILLION, "critical": style.PURPLE}
