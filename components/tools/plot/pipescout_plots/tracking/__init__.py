# SPDX-License-Identifier: Apache-2.0
"""Pictures of the track of a pipe, and of the arm that keeps it in view. `subject` knows them all."""
