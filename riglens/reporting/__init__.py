"""Reports on rigs: figures, drawings, the page from its templates, the PDF, and the check of an earlier one."""
