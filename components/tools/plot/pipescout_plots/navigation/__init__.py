# SPDX-License-Identifier: Apache-2.0
"""Pictures of a robot that is navigated through a plant."""
