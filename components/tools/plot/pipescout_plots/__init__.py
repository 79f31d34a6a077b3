# SPDX-License-Identifier: Apache-2.0
"""Pictures of what missions recorded. One module per picture; `command_line` knows the subjects."""
