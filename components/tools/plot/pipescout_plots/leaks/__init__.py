# SPDX-License-Identifier: Apache-2.0
"""Pictures of leaks that a thermal camera found."""
