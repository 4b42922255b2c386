"""What a grasp does when the table lets go, predicted from the snapshot."""
