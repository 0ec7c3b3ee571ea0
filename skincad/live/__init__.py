"""The page with sliders: what is edited, what answers it, and the browser's side of both."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    channels: ChannelsPage envelope
    page: Page
    serve: free_port
    session: apply_moves start_session
    shapes: view
    """,
)
