"""The report: one HTML page that holds everything it shows and loads nothing."""

from a2s_drake.views.report.page import report_html

__all__ = ["report_html"]
