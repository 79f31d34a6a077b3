# SPDX-License-Identifier: Apache-2.0
"""Pictures of flights over a pipe rack. One module per picture; `subject` knows them all."""
