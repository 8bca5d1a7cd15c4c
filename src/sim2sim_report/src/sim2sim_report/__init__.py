# SPDX-License-Identifier: BSD-3-Clause
"""A run as one HTML file: `results` reads it, `figures` draws it, `page` puts it together."""
